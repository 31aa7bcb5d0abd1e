#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <sstream>

#include "support/machine_path.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// The sample of every dialect's golden text: three poses of a trunnion, a link, a rotary move on the spot.
MachinePath sample(bool tcp) {
    PosePath poses;
    const auto leaning = [](double deg) { return Vec3(std::sin(radians(deg)), 0, std::cos(radians(deg))); };
    poses.cl = {{10, 20, 5}, {11, 20, 5}, {11, 20, 5}, {11, 20, 45}};
    poses.axis = {leaning(15), leaning(15), leaning(16.5), leaning(16.5)};
    poses.contact.assign(4, -1);
    poses.passes = {{0, 3, PassKind::cut, false}, {3, 1, PassKind::link, true}};
    return path_on(*built_in_machine("bc-table-table"), poses, tcp);
}

TEST(Program, LinuxcncUnderToolCentrePointControlLooksLikeThis) {
    const auto text = write_program(sample(true), {.title = "sample (of) work", .tool_number = 3, .spindle_rpm = 9000});
    ASSERT_TRUE(text) << text.error().text();
    EXPECT_EQ(*text,
              "(Trunnion " TRUNNION_VERSION
              ": sample <of> work)\n"
              "(machine bc-table-table, tool 3 of length 120.0000 mm)\n"
              "(tool-centre-point control: X Y Z are the tool tip in the work coordinates G54)\n"
              "(rapid links are G0, straight in these words  G1 where rotary axes turn, since joint speeds are not watched)\n"
              "(start with the tool clear of the work)\n"
              "G21 G17 G90 G94 G40 G80\n"
              "G64 P0.0010\n"
              "G0 B0 C0\n"
              "G49\n"
              "T3 M6\n"
              "S9000 M3\n"
              "G43 H3\n"
              "G53 G0 Z1000\n"
              "(pass 0: cut)\n"
              "G0 X10 Y20 Z5 B15 C0\n"
              "G1 X11 F1500\n"
              "B16.5 F9000\n"
              "(pass 1: link)\n"
              "G0 Z45\n"
              "M5\n"
              "M2\n");
}

TEST(Program, LinuxcncWithoutItHoldsMachinePositionsAndInverseTime) {
    const MachinePath path = sample(false);
    const auto text = write_program(path, {.tcp = false});
    ASSERT_TRUE(text) << text.error().text();
    EXPECT_THAT(*text, HasSubstr("no tool-centre-point control: machine positions of the gauge point, G54 must be zero"));
    EXPECT_THAT(*text, Not(HasSubstr("G43")));
    // Geometric check of the first block by hand: the table turns by -15 degrees about Y, the gauge point is 120 mm up.
    const double c = std::cos(radians(15)), s = std::sin(radians(15));
    char first[200];
    std::snprintf(first, sizeof first, "G53 G0 Z1000\nG93\n(pass 0: cut)\nG0 X%.6f Y20 B15 C0\nG0 Z%.5f\nG1 ", 10 * c - 5 * s,
                  5 * c + 10 * s + 120);
    EXPECT_THAT(*text, HasSubstr(first));
    EXPECT_TRUE(std::regex_search(*text, std::regex("G1 X[0-9.]+ Z[0-9.]+ F1500\n"))) << *text;  // 1 mm at 1500 mm/min
}

TEST(Program, CldataLooksLikeThis) {
    const auto text = write_program(sample(true), {.dialect = "apt", .title = "sample", .tool_diameter = 12, .tool_corner = 2});
    ASSERT_TRUE(text) << text.error().text();
    EXPECT_EQ(*text,
              "PARTNO/sample\n"
              "$$ Trunnion " TRUNNION_VERSION
              ", machine bc-table-table\n"
              "UNITS/MM\n"
              "MULTAX/ON\n"
              "CUTTER/12.000000,2.000000\n"
              "LOADTL/1,LENGTH,120.000000\n"
              "$$ pass 0: cut\n"
              "FEDRAT/1500,MMPM\n"
              "GOTO/10,20,5,0.2588190451,0,0.9659258263\n"
              "GOTO/11,20,5,0.2588190451,0,0.9659258263\n"
              "GOTO/11,20,5,0.2840153447,0,0.9588197349\n"
              "$$ pass 1: link\n"
              "RAPID\n"
              "GOTO/11,20,45,0.2840153447,0,0.9588197349\n"
              "END\n"
              "FINI\n");
}

TEST(Program, WhatIsWrittenIsReadBackOnEveryMachineInEveryDialect) {
    for (const std::string& name : built_in_machine_names()) {
        const Machine machine = *built_in_machine(name);
        for (const std::string& dialect : dialect_names())
            for (const bool tcp : {true, false}) {
                const Dialect known = *find_dialect(dialect);
                if (!tcp && !known.without_tcp && dialect != "apt") continue;
                const MachinePath path = path_on(machine, wandering_poses(700, 3), tcp);
                ASSERT_TRUE(path.valid()) << name;
                const auto text = write_program(path, {.dialect = dialect, .tcp = tcp});
                ASSERT_TRUE(text) << text.error().text();
                const auto program = read_program(*text, dialect, &machine, kToolLength);
                ASSERT_TRUE(program) << name << ' ' << dialect << ": " << program.error().text();
                EXPECT_EQ(program->dialect, dialect);
                // Without the name the family is recognised.
                const auto guessed = read_program(*text, "", &machine, kToolLength);
                ASSERT_TRUE(guessed) << guessed.error().text();
                EXPECT_EQ(find_dialect(guessed->dialect)->syntax, known.syntax) << dialect;
                EXPECT_EQ(program->tcp, tcp || dialect == "apt");
                const auto back = compare_with_path(*program, path);
                ASSERT_TRUE(back) << name << ' ' << dialect << ": " << back.error().text();
                // Half a unit of the last decimal in each word: 5e-5 sqrt(3) mm, 5e-5 sqrt(2) deg at four decimals.
                const bool fine = known.linear_decimals > 5;
                EXPECT_LT(back->tip, fine ? 1e-6 : 8.7e-5) << dialect;
                EXPECT_LT(back->axis, fine ? 1e-9 : 1.3e-6) << dialect;
                EXPECT_LT(back->motion_axis, radians(5));
                EXPECT_EQ(back->blocks, 700u);
                // Durations: what the blocks say is what the path planned.
                for (std::size_t i = 1; i < 700; ++i) {
                    const ProgramBlock& block = program->blocks[i];
                    if (block.rapid) continue;
                    // Linear words of four decimals over blocks of 0.5 mm and more; feeds of four decimals of mm/min.
                    if (i == 350 || i == 360) continue;  // links at feed
                    ASSERT_NEAR(block.feed / path.feed()[i], 1.0, fine ? 2e-5 : 1e-3) << name << ' ' << dialect << " pose " << i;
                }
            }
    }
}

TEST(Program, NoLineIsLongAndNoWordHasAnExponent) {
    PosePath poses = wandering_poses(200, 4);
    for (Vec3& cl : poses.cl) cl *= 1e-5;  // tiny moves, tiny feeds
    const MachinePath path = path_on(*built_in_machine("linuxcnc-xyzac-trt"), poses);
    const auto text = write_program(path, {.title = std::string(1000, 'x') + "\n(MSG, hello)"});
    ASSERT_TRUE(text);
    EXPECT_FALSE(std::regex_search(*text, std::regex("[0-9]e[-+0-9]")));
    EXPECT_THAT(*text, Not(HasSubstr("(MSG")));
    std::istringstream lines(*text);
    for (std::string line; std::getline(lines, line);) ASSERT_LT(line.size(), 200u);
}

TEST(Program, InvalidPosesAreRefusedUnlessAllowedAndThenMarked) {
    auto path = move_machine(detail::CheckedPathMaker::refused_for_test(wandering_poses(100, 5), radians(5), 41,
                                                                        "holder (upper) touches face 3; stop"),
                             *built_in_machine("ac-table-table"), {.tool_length = kToolLength}, {});
    ASSERT_TRUE(path);
    const auto refused = write_program(*path, {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::invalid_input);
    EXPECT_THAT(refused.error().text(), HasSubstr("1 of 100 poses are not valid"));
    EXPECT_THAT(refused.error().text(), HasSubstr("pose 41: holder (upper) touches face 3"));
    for (const std::string& dialect : dialect_names()) {
        const auto text = write_program(*path, {.dialect = dialect, .allow_invalid = true});
        ASSERT_TRUE(text) << text.error().text();
        EXPECT_THAT(*text, HasSubstr("INVALID: holder <upper> touches face 3  stop"));
        const auto program = read_program(*text, dialect, &path->machine(), kToolLength);
        ASSERT_TRUE(program) << program.error().text();
        EXPECT_TRUE(compare_with_path(*program, *path));
    }
}

TEST(Program, AMachineWithoutToolCentrePointControlGetsNoProgramUnderIt) {
    Machine machine = *built_in_machine("ac-table-table");
    machine.tcp = false;
    const MachinePath path = path_on(machine, wandering_poses(50, 6));
    EXPECT_THAT(write_program(path, {}).error().text(), HasSubstr("no tool-centre-point control"));
    EXPECT_TRUE(write_program(path, {.tcp = false}));
    EXPECT_TRUE(write_program(path, {.dialect = "apt"}));
}

TEST(Program, AnUnknownDialectGetsTheNearestOne) {
    const MachinePath path = path_on(*built_in_machine("ac-table-table"), wandering_poses(20, 7));
    EXPECT_THAT(write_program(path, {.dialect = "linuxcn"}).error().text(), HasSubstr("did you mean \"linuxcnc\"?"));
    EXPECT_THAT(dialect_names(),
                ElementsAre("apt", "fanuc", "fanuc-vector", "heidenhain", "heidenhain-m128", "heidenhain-vector", "linuxcnc",
                            "makino", "mikron", "mitsubishi", "mitsubishi-vector", "siemens", "siemens-vector"));
    EXPECT_EQ(file_ending("apt"), "cls");
    EXPECT_EQ(file_ending("linuxcnc"), "ngc");
}

TEST(Program, AChangedProgramIsFoundOutWithItsLine) {
    const Machine machine = *built_in_machine("ac-table-table");
    const MachinePath path = path_on(machine, wandering_poses(100, 8));
    const std::string text = *write_program(path, {});
    const auto verdict = [&](const std::string& changed) -> std::string {
        const auto program = read_program(changed, "linuxcnc", &machine, kToolLength);
        if (!program) return program.error().text();
        const auto same = compare_with_path(*program, path);
        return same ? "same" : same.error().text();
    };
    EXPECT_EQ(verdict(text), "same");
    // A digit of one word: 2e-4 mm.
    const std::size_t block = text.find("\nX", text.size() / 3) + 1;
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(block), '\n') + 1;
    std::string changed = text;
    const std::size_t end = changed.find(' ', block);
    char word[40];
    std::snprintf(word, sizeof word, "X%.6f", std::stod(changed.substr(block + 1, end - block - 1)) + 2e-4);
    changed.replace(block, end - block, word);
    EXPECT_THAT(verdict(changed), HasSubstr("line " + std::to_string(line) + ": "));
    // A block gone, the end gone.
    changed = text;
    changed.erase(block, changed.find('\n', block) - block + 1);
    EXPECT_THAT(verdict(changed), HasSubstr("99 motion blocks but the path 100 poses"));
    EXPECT_THAT(verdict(text.substr(0, text.size() - 3)), HasSubstr("no end"));
}

}  // namespace
}  // namespace trunnion
