#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

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

TEST(ReadApt, AnArcIsItsChordsOnTheCircleInItsSense) {
    for (const double side : {1.0, -1.0})
        for (const double degrees_of_arc : {30.0, 90.0, 200.0, 330.0, 360.0}) {
            const double end = side * radians(degrees_of_arc);
            const auto p =
                read(fmt::format("MULTAX/ON\nFEDRAT/600,MMPM\nGOTO/{},2,3,0,0,1\nCIRCLE/1,2,3,0,0,{},10,0.01,0.5,12,0\n"
                                 "GOTO/{:.6f},{:.6f},3\nGOTO/0,0,50\nFINI\n",
                                 11, side, 1 + 10 * std::cos(end), 2 + 10 * std::sin(end)));
            ASSERT_TRUE(p) << p.error().text();
            double length = 0, worst = 0;
            const std::size_t last = p->blocks.size() - 2;
            for (std::size_t i = 1; i <= last; ++i) {
                const Vec3 a = p->blocks[i - 1].tip.cl, b = p->blocks[i].tip.cl;
                length += (b - a).norm();
                worst = std::max(worst, std::abs((0.5 * (a + b) - Vec3(1, 2, 3)).norm() - 10));
                ASSERT_GT(side * (a - Vec3(1, 2, 3)).cross(b - Vec3(1, 2, 3)).z(), 0);
                ASSERT_EQ(p->blocks[i].line, 5);
                ASSERT_EQ(p->blocks[i].feed, 10);
            }
            EXPECT_NEAR(length, 10 * radians(degrees_of_arc), 2e-3);
            EXPECT_LE(worst, 5.1e-4);
        }
}

/// What the large systems write, typed after their manuals and sample files: heads, tools, feeds, continuation lines, comments.
TEST(ReadApt, ReadsTheManyFormsOfTheLargeSystems) {
    struct Sample {
        const char *system, *text;
        std::size_t blocks;
        Vec3 last, axis;
        double feed;
    };
    const Sample samples[] = {
        {"NX",
         "TOOL PATH/CONTOUR_PROFILE,TOOL,MILL_D10\nTLDATA/MILL,10.0000,1.0000,75.0000,0.0000,0.0000\n"
         "MSYS/0.0000,0.0000,0.0000,1.0000000,0.0000000,0.0000000,0.0000000,1.0000000,0.0000000\n$$ centerline data\n"
         "PAINT/PATH\nPAINT/SPEED,10\nLOAD/TOOL,1\nSPINDL/RPM,8000,CLW\nPAINT/COLOR,186\nRAPID\n"
         "GOTO/10.0000,0.0000,50.0000,0.0000000,0.0000000,1.0000000\nPAINT/COLOR,42\nFEDRAT/MMPM,500.0000\n"
         "GOTO/10.0000,0.0000,5.0000\nCIRCLE/"
         "0.0000,0.0000,5.0000,0.0000000,0.0000000,1.0000000,10.0000,0.0100,0.5000,10.0000,1.0000\n"
         "GOTO/0.0000,10.0000,5.0000\nGOTO/0.0000,12.0000,5.0000,0.6000000,0.0000000,0.8000000\nPAINT/SPEED,10\nEND-OF-PATH\n",
         0,
         {0, 12, 5},
         {0.6, 0, 0.8},
         500 / 60.0},
        {"Creo",
         "$$*         Pro/CLfile  Version Creo Parametric\n$$-> MFGNO / BLADE\nPARTNO / BLADE\n$$-> FEATNO / 25\n"
         "MACHIN / UNCX01, 1\n$$-> CUTCOM_GEOMETRY_TYPE / OUTPUT_ON_CENTER\nUNITS / INCHES\nLOADTL / 1, OSETNO, 1\n"
         "$$-> CUTTER / 0.500000\n$$-> CSYS / 1.0000000000, 0.0000000000, 0.0000000000, 0.0000000000, $\n"
         "        0.0000000000, 1.0000000000, 0.0000000000, 0.0000000000\n"
         "MULTAX / ON\nSPINDL / RPM, 5000.000000,  CLW\nRAPID\n"
         "GOTO / 1.0000000000, 0.0000000000, 2.0000000000, $\n0.0000000000, 0.0000000000, 1.0000000000\nFEDRAT / 20.000000,  "
         "IPM\n"
         "GOTO / 1.0000000000, 0.0000000000, 0.5000000000, $\n0.0000000000, 0.6000000000, 0.8000000000\nSPINDL / OFF\nMULTAX / "
         "OFF\nFINI\n",
         2,
         {25.4, 0, 12.7},
         {0, 0.6, 0.8},
         20 * 25.4 / 60},
        {"CATIA",
         "$$ -----------------------------------------------------------------\n$$     Generated on Tuesday\n$$ CATIA APT "
         "VERSION 1.0\n"
         "$$ Manufacturing Program.1\n$$ Part Operation.1\n$$*CATIA0\n$$ Manufacturing Program.1\n$$   1.00000   0.00000   "
         "0.00000    0.00000\n"
         "PARTNO PART TO BE MACHINED\nCUTTER/ 10.000000,  2.000000,  3.000000,  2.000000,  0.000000,$\n         0.000000, "
         "50.000000\n"
         "TOOLNO/1,   10.000000\nTPRINT/T1 End Mill D 10,,T1 End Mill D 10\nLOADTL/1\n$$ Start generation of : Tool Change.1\n"
         "MULTAX\nFEDRAT/  300.0000,MMPM\nSPINDL/   70.0000,RPM,CLW\nGOTO  /   10.00000,   20.00000,   30.00000, 0.000000, "
         "0.000000, 1.000000\n"
         "RAPID\nGOTO  /   10.00000,   20.00000,   80.00000, 0.000000,-0.600000, 0.800000\n$$ End of "
         "generation\nSPINDL/OFF\nREWIND/0\nEND\nFINI\n",
         2,
         {10, 20, 80},
         {0, -0.6, 0.8},
         0},
    };
    for (const Sample& sample : samples) {
        const auto p = read(sample.text);
        ASSERT_TRUE(p) << sample.system << ": " << p.error().text();
        if (sample.blocks > 0) EXPECT_EQ(p->blocks.size(), sample.blocks) << sample.system;
        const ProgramBlock& last = p->blocks.back();
        EXPECT_LT((last.tip.cl - sample.last).norm(), 1e-9) << sample.system;
        EXPECT_LT((last.tip.axis - sample.axis).norm(), 1e-9) << sample.system;
        EXPECT_NEAR(last.feed, sample.feed, 1e-9) << sample.system;
    }
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
        {"\nCIRCLE/1,2,3,0,0,1,5\nFINI\n", "line 3: CIRCLE without the GOTO"},
        {"CIRCLE/0,0,0,0,0,1,5\nGOTO/5,0,0\nFINI\n", "line 2: an arc (CIRCLE) before the first position"},
        {"GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,6,0\nFINI\n", "line 3: an end of the arc is 6.0000 mm from the centre"},
        {"GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0,0,1,0\nFINI\n", "line 3: an arc (CIRCLE) on which the tool axis turns"},
        {"GOTO/5,0,0\nCIRCLE/0,0,0,0,0,2,5\nFINI\n", "line 2: CIRCLE has an axis of length 2"},
        {"GOTO/5,0,0\nCIRCLE/0,0,0,5\nFINI\n", "line 2: CIRCLE needs centre, axis and radius"},
        {"ARCSLP/ON\nFINI\n", "line 1: ARCSLP changes the path in a way that is not read"},
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
