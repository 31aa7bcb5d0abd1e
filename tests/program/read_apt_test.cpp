#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "trunnion/program/program.hpp"

namespace trunnion {
namespace {

using testing::HasSubstr;

Result<ProgramText> read(std::string_view text) {
    return read_program(text, "apt", nullptr, 0);
}

TEST(ReadApt, ReadsWhatCamSystemsWrite) {
    const auto p = read(
        "TOOL PATH/FINISH_BLADE,TOOL,BALL_10\n"
        "TLDATA/MILL,10.0000,5.0000,75.0000,0.0000,0.0000\n"
        "MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000\n"
        "$$ centerline data\n"
        "PAINT/PATH\n"
        "PARTNO any text, with / and , in it\n"
        "LOADTL/1,ADJUST,1\r\n"
        "SPINDL/RPM,8000,CLW\n"
        "RAPID\n"
        "GOTO/1.5,-2,+3,0,0,1\n"
        "FEDRAT/MMPM,600.0000\n"
        "GOTO/ 2.5 , -2.0, 3.0, $\n"
        "   0.6, 0.0, $$ in the middle of a statement\n"
        "GOTO/9,9,9\n"
        "END-OF-PATH\n");
    // Line 12 ends in $, line 13 does not: the statement ends in a comma and is wrong.
    ASSERT_FALSE(p);
    EXPECT_THAT(p.error().text(), HasSubstr("line 12: number 6 cannot be read"));

    const auto good = read(
        "PARTNO/X\nMULTAX\nRAPID\nGOTO/1.5,-2,+3,0,0,1\nfedrat/600.0,mmpm\n"
        "goto/ 2.5 , -2.0, 3.0, $\n   0.6, 0.0, $ $$ comment\n 8.0E-1 $$ the end\nGOTO/9,9,9\nCUTCOM/OFF\nFINI\n");
    ASSERT_TRUE(good) << good.error().text();
    ASSERT_EQ(good->blocks.size(), 3u);
    EXPECT_TRUE(good->blocks[0].rapid);
    EXPECT_EQ(good->blocks[0].tip.cl, Vec3(1.5, -2, 3));
    EXPECT_FALSE(good->blocks[1].rapid);
    EXPECT_EQ(good->blocks[1].line, 6);
    EXPECT_DOUBLE_EQ(good->blocks[1].feed, 10.0);
    EXPECT_LT((good->blocks[1].tip.axis - Vec3(0.6, 0, 0.8)).norm(), 1e-15);
    EXPECT_EQ(good->blocks[2].tip.cl, Vec3(9, 9, 9));
    EXPECT_EQ(good->blocks[2].tip.axis, good->blocks[1].tip.axis);
    EXPECT_FALSE(good->blocks[2].has_joints);
}

TEST(ReadApt, InchesAreConvertedWithTheirFeeds) {
    const auto p =
        read("UNITS/INCHES\nFEDRAT/60,IPM\nGOTO/1,2,3,0,1,0\nFEDRAT/120\nGOTO/2,2,3\nFEDRAT/254,MMPM\nGOTO/0,0,0\nFINI\n");
    ASSERT_TRUE(p) << p.error().text();
    EXPECT_LT((p->blocks[0].tip.cl - Vec3(25.4, 50.8, 76.2)).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(p->blocks[0].feed, 25.4);
    EXPECT_DOUBLE_EQ(p->blocks[1].feed, 50.8);
    EXPECT_NEAR(p->blocks[2].feed, 254 / 60.0, 1e-12);
}

TEST(ReadApt, FromSetsTheAxisAndIsNoMotion) {
    const auto p = read("FROM/0,0,100,1,0,0\nGOTO/1,2,3\nTLAXIS/0,1,0\nGOTO/1,2,4\nMULTAX/OFF\nGOTO/1,2,5\nFINI\n");
    ASSERT_TRUE(p) << p.error().text();
    ASSERT_EQ(p->blocks.size(), 3u);
    EXPECT_EQ(p->blocks[0].tip.axis, Vec3(1, 0, 0));
    EXPECT_EQ(p->blocks[1].tip.axis, Vec3(0, 1, 0));
    EXPECT_EQ(p->blocks[2].tip.axis, Vec3(0, 0, 1));
}

struct Bad {
    const char *text, *message;
};

TEST(ReadApt, WhatItCannotKnowItRefusesWithTheLine) {
    const Bad files[] = {
        {"GOTO/1,2,3\n", "line 1: the file has no FINI"},
        {"", "line 0: the file has no FINI"},
        {"GOTO/1,2,3,$\n", "line 1: the file ends in the middle of a statement"},
        {"GOTO/1,2,\nFINI\n", "line 1: number 3 cannot be read"},
        {"GOTO/1,2\nFINI\n", "line 1: GOTO needs three numbers, or six"},
        {"GOTO/1,2,nan\nFINI\n", "line 1: number 3 cannot be read (\"nan\")"},
        {"GOTO/1,2,1e999\nFINI\n", "line 1: number 3 cannot be read"},
        {"GOTO/1 2 3\nFINI\n", "line 1: a comma is missing before \"2 3\""},
        {"GOTO/1,2,3,0,0,2\nFINI\n", "line 1: the tool axis (0, 0, 2) has length 2"},
        {"GOTO/1,2,3,0,0,0\nFINI\n", "line 1: the tool axis (0, 0, 0) has length 0"},
        {"MULTAX/OFF\nGOTO/1,2,3,0,0,1\nFINI\n", "line 2: GOTO with a tool axis after MULTAX/OFF"},
        {"\nCIRCLE/1,2,3,0,0,1,5\nFINI\n", "line 2: CIRCLE changes the path in a way that is not read"},
        {"CYCLE/DRILL,5\nFINI\n", "line 1: CYCLE changes the path"},
        {"GODLTA/0,0,5\nFINI\n", "line 1: GODLTA changes the path"},
        {"MSYS/0,0,5,1,0,0,0,1,0\nFINI\n", "line 1: MSYS moves or turns"},
        {"GOTTO/1,2,3\nFINI\n", "line 1: unknown statement \"GOTTO\"; is \"GOTO\" meant?"},
        {"UNITS/FURLONGS\nFINI\n", "line 1: UNITS/FURLONGS is not understood"},
        {"FEDRAT/0.1,MMPR\nFINI\n", "line 1: \"MMPR\" in FEDRAT is not understood"},
        {"FEDRAT/-5\nFINI\n", "line 1: FEDRAT needs a number greater than zero"},
        {"GOTO/1,2,3\nUNITS/INCHES\nFINI\n", "line 2: UNITS after the first GOTO"},
        {"FINI\nGOTO/1,2,3\n", "line 2: a statement after FINI"},
    };
    for (const Bad& bad : files) {
        const auto p = read(bad.text);
        ASSERT_FALSE(p) << bad.text;
        EXPECT_EQ(p.error().code, ErrorCode::unreadable);
        EXPECT_THAT(p.error().text(), HasSubstr(bad.message));
    }
}

}  // namespace
}  // namespace trunnion
