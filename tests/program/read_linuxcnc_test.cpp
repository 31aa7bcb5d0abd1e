#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "trunnion/program/program.hpp"

namespace trunnion {
namespace {

using testing::HasSubstr;

const Machine& machine() {
    static const Machine m = *built_in_machine("linuxcnc-xyzac-trt");
    return m;
}
Result<ProgramText> read(std::string_view text) {
    return read_program(text, "linuxcnc", &machine(), 100);
}

TEST(ReadLinuxcnc, ReadsWordsAsTheStandardDoes) {
    const auto p = read(
        "%\n"
        "n10 g21g90 g94 (comment) T1 M6\r\n"
        "G43 H1 ; to the end (of the line\n"
        "g0 x 1 0. y+2z-.5 a0c0\n"
        "\n"
        "N30 G1 X1 1 F600\n"
        "Y3\n"
        "G0 Z5\n"
        "G93 G1 X13 F30\n"
        "G94 G1 A-90 F180\n"
        "%\n");
    ASSERT_TRUE(p) << p.error().text();
    EXPECT_TRUE(p->tcp);
    ASSERT_EQ(p->blocks.size(), 6u);
    EXPECT_EQ(p->blocks[0].line, 4);
    EXPECT_TRUE(p->blocks[0].rapid);
    EXPECT_EQ(p->blocks[0].tip.cl, Vec3(10, 2, -0.5));
    EXPECT_EQ(p->blocks[1].tip.cl, Vec3(11, 2, -0.5));
    EXPECT_DOUBLE_EQ(p->blocks[1].feed, 10.0);
    EXPECT_EQ(p->blocks[2].tip.cl, Vec3(11, 3, -0.5));
    EXPECT_DOUBLE_EQ(p->blocks[2].feed, 10.0);
    EXPECT_TRUE(p->blocks[3].rapid);
    EXPECT_EQ(p->blocks[3].feed, 0.0);
    EXPECT_DOUBLE_EQ(p->blocks[4].seconds, 2.0);  // 1/30 min
    EXPECT_DOUBLE_EQ(p->blocks[4].feed, 1.0);
    EXPECT_DOUBLE_EQ(p->blocks[5].seconds, 30.0);  // 90 degrees at 180 per minute
    EXPECT_DOUBLE_EQ(p->blocks[5].joints[3], -kPi / 2);
    EXPECT_NEAR(p->blocks[5].feed, 0.0, 1e-12);
    EXPECT_LT((p->blocks[5].tip.axis - Vec3(0, -1, 0)).norm(), 1e-15);
    EXPECT_LT((p->blocks[5].tip.cl - Vec3(13, 3, 5)).norm(), 1e-12);
}

TEST(ReadLinuxcnc, InchesAreConvertedWithTheirFeeds) {
    const auto p = read("G20 G43 H1\nG0 X1 Y0 Z0 A10 C0\nG1 X2 F60\nM30\n");
    ASSERT_TRUE(p) << p.error().text();
    EXPECT_DOUBLE_EQ(p->blocks[1].tip.cl.x(), 50.8);
    EXPECT_DOUBLE_EQ(p->blocks[1].feed, 25.4);
    EXPECT_DOUBLE_EQ(p->blocks[1].joints[3], radians(10));
}

TEST(ReadLinuxcnc, WithoutToolLengthTheWordsAreMachinePositions) {
    const auto p = read("G21\nG0 X1 Y2 Z203 A0 C90\nG1 X5 F60\nM2\n");
    ASSERT_TRUE(p) << p.error().text();
    EXPECT_FALSE(p->tcp);
    EXPECT_EQ(p->blocks[0].joints[0], 1.0);
    EXPECT_LT((p->blocks[0].tip.cl - Vec3(2, -1, 103)).norm(), 1e-12);  // Rz(90)^T (1, 2), and 100 mm of tool
    EXPECT_NEAR(p->blocks[1].feed, 1.0, 1e-12);
    EXPECT_NEAR(p->blocks[1].seconds, 4.0, 1e-12);
}

TEST(ReadLinuxcnc, MachineCoordinatesLeaveThePositionOpen) {
    const auto p = read("G43 H1\nG0 X0 Y0 Z0 A0 C0\nG53 G0 Z300\nX5\nZ1\nM2\n");
    ASSERT_TRUE(p) << p.error().text();
    ASSERT_EQ(p->blocks.size(), 2u);
    EXPECT_EQ(p->blocks[1].tip.cl, Vec3(5, 0, 1));
}

struct Bad {
    const char *text, *message;
};

TEST(ReadLinuxcnc, WhatItCannotKnowItRefusesWithTheLine) {
    const Bad programs[] = {
        {"G0 X0 Y0 Z0 A0 C0\nG2 X1 I1 F100\nM2\n", "line 2: G2 is not a code that is read; arcs are not read"},
        {"G91\nM2\n", "line 1: G91 is not a code that is read; incremental"},
        {"G43.4 H1\nM2\n", "line 1: G43.4 is not a code"},
        {"\n\nM128\nM2\n", "line 3: M128 is not a code"},
        {"G0 X1 X2\nM2\n", "line 1: word X stands twice"},
        {"G0 X1e-3\nM2\n", "line 1: word E has no meaning here"},
        {"G0 X1e3 Y1E4\nM2\n", "line 1: word E stands twice"},
        {"G0 Xnan\nM2\n", "line 1: word X has no number"},
        {"G0 X--1\nM2\n", "line 1: word X has no number"},
        {"G0 X+-1\nM2\n", "line 1: word X has no number"},
        {"G0 X\nM2\n", "line 1: word X has no number"},
        {"G0 X1.2.3\nM2\n", "line 1: \".3\" is not a word"},
        {"G0 B1\nM2\n", "line 1: word B is not an axis of machine linuxcnc-xyzac-trt"},
        {"G0 G1 X1\nM2\n", "line 1: G0 and G1 exclude each other"},
        {"X1\nM2\n", "line 1: axis words without G0 or G1"},
        {"G1 X1\nM2\n", "line 1: G1 without a feed"},
        {"G1 X1 F0\nM2\n", "line 1: F must be greater"},
        {"G93\nG1 X1 F2\nX2\nM2\n", "line 3: G1 in G93 needs an F of its own"},
        {"G93 G1 X1 F2\nG94 X2\nM2\n", "line 2: G1 without a feed"},
        {"G0 X1 (open\nM2\n", "line 1: a comment is not closed"},
        {"G0 X1 (a (b) c)\nM2\n", "line 1: a comment inside a comment"},
        {"G0 X#1\nM2\n", "line 1: parameters"},
        {"G0 X[1+2]\nM2\n", "line 1: parameters"},
        {"o100 sub\nM2\n", "line 1: parameters, expressions and O words"},
        {"/G0 X1\nM2\n", "line 1: an optional block"},
        {"G0 X1 P2\nM2\n", "line 1: word P has no meaning here"},
        {"G43\nM2\n", "line 1: G43 without H"},
        {"G0 X1 Y1 Z1 A0 C0\n", "line 1: the program has no end"},
        {"", "line 0: the program has no end"},
        {"%\nG0 X1 Y1 Z1 A0 C0\n", "line 2: the program has no end"},
        {"G0 X1 Y1 Z1 A0 C0\n%\n", "line 2: a % in the middle"},
        {"G0 X1 Y1 Z1 A0 C0\nM2\nG0 X2\n", "line 3: words after the end"},
        {"G0 X1 Y1 Z1\nM2\n", "never states a position of all five axes X Y Z A C"},
        {"G0 X1 Y1 Z1 A0 C0\nG43 H1\nG0 X0 Y0 Z0 A0 C0\nM2\n", "line 3: a move after the tool length was switched"},
    };
    for (const Bad& bad : programs) {
        const auto p = read(bad.text);
        ASSERT_FALSE(p) << bad.text;
        EXPECT_EQ(p.error().code, ErrorCode::unreadable);
        EXPECT_THAT(p.error().text(), HasSubstr(bad.message));
    }
    EXPECT_THAT(read("(" + std::string(300, 'x') + ")\nM2\n").error().text(), HasSubstr("line 1: the line has 302 characters"));
}

TEST(ReadLinuxcnc, NeedsAMachine) {
    EXPECT_THAT(read_program("G0 X1\nM2\n", "linuxcnc", nullptr, 0).error().text(), HasSubstr("name the machine"));
}

}  // namespace
}  // namespace trunnion
