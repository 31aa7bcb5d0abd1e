#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "support/machine_path.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion {
namespace {

using testing::HasSubstr;

/// The sample of every golden text: three poses of a trunnion, a link, a turn on the spot (not in a plane).
MachinePath sample(bool tcp, bool plane) {
    PosePath poses;
    const auto leaning = [](double deg) { return Vec3(std::sin(radians(deg)), 0, std::cos(radians(deg))); };
    const double last = plane ? 15 : 16.5;
    poses.cl = {{10, 20, 5}, {11, 20, 5}, {11, 20, 5}, {11, 20, 45}};
    poses.axis = {leaning(15), leaning(15), leaning(last), leaning(last)};
    poses.contact.assign(4, -1);
    poses.passes = {{0, 3, PassKind::cut, false}, {3, 1, PassKind::link, true}};
    return path_on(*built_in_machine("bc-table-table"), poses, tcp);
}

std::string golden(const std::string& name) {
    std::ifstream file(std::string(TRUNNION_SOURCE_DIR) + "/tests/program/golden/" + name + ".txt");
    std::stringstream text;
    text << file.rdbuf();
    std::string all = text.str();
    const std::size_t at = all.find("VERSION");
    if (at != std::string::npos) all.replace(at, 7, TRUNNION_VERSION);
    return all;
}

std::string written(const std::string& dialect, bool tcp = true, bool plane = false) {
    const auto text = write_program(sample(tcp, plane), {.dialect = dialect,
                                                         .tcp = tcp,
                                                         .plane = plane,
                                                         .title = "sample",
                                                         .tool_number = 3,
                                                         .tool_diameter = 12,
                                                         .spindle_rpm = 9000});
    return text ? *text : text.error().text();
}

// The golden files were read line by line against the formats of the sheet before they were kept.
TEST(Dialects, EveryOneWritesItsGoldenFile) {
    for (const std::string& dialect : dialect_names()) EXPECT_EQ(written(dialect), golden(dialect)) << dialect;
    for (const char* dialect : {"fanuc", "siemens", "linuxcnc"})
        EXPECT_EQ(written(dialect, false), golden(std::string(dialect) + "-machine")) << dialect;
    for (const char* dialect : {"fanuc", "siemens", "heidenhain", "linuxcnc"})
        EXPECT_EQ(written(dialect, true, true), golden(std::string(dialect) + "-plane")) << dialect;
}

TEST(Dialects, WhatAControlHasNotIsRefusedInASentence) {
    EXPECT_THAT(written("heidenhain", false), HasSubstr("under tool-centre-point control only"));
    EXPECT_THAT(written("siemens-vector", false), HasSubstr("under tool-centre-point control only"));
    EXPECT_THAT(written("fanuc-vector", true, true), HasSubstr("dialect fanuc-vector has no tilted plane"));
    EXPECT_THAT(
        write_program(path_on(*built_in_machine("bc-table-table"), wandering_poses(50, 2)), {.dialect = "fanuc", .plane = true})
            .error()
            .text(),
        HasSubstr("needs one orientation for the whole path, but at pose 1 "));
}

/// All poses with one axis.
PosePath tilted_poses(std::size_t n, const Vec3& axis) {
    PosePath poses = wandering_poses(n, 11);
    for (Vec3& a : poses.axis) a = axis;
    return poses;
}

TEST(Dialects, APlaneProgramOfAnyOrientationOnAnyMachineIsReadBack) {
    int written_programs = 0;
    for (const std::string& name : built_in_machine_names())
        for (int k = 0; k < 40; ++k) {
            const double tilt = k == 0 ? 0.0 : radians(2.1 * k), azimuth = 2.4 * k;
            const Vec3 axis(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
            const MachinePath path = path_on(*built_in_machine(name), tilted_poses(60, axis));
            if (!path.valid()) continue;
            for (const char* dialect : {"fanuc", "makino", "mitsubishi", "siemens", "heidenhain", "mikron", "linuxcnc"}) {
                const auto text = write_program(path, {.dialect = dialect, .plane = true});
                ASSERT_TRUE(text) << text.error().text();
                const auto program = read_program(*text, dialect, &path.machine(), kToolLength);
                ASSERT_TRUE(program) << name << ' ' << dialect << ' ' << k << ": " << program.error().text() << '\n' << *text;
                const auto same = compare_with_path(*program, path);
                ASSERT_TRUE(same) << name << ' ' << dialect << ' ' << k << ": " << same.error().text();
                ++written_programs;
            }
        }
    EXPECT_GT(written_programs, 1000);
}

TEST(Dialects, APlaneThatDoesNotFitTheRotaryAxesIsRefused) {
    const MachinePath path = path_on(*built_in_machine("bc-table-table"), tilted_poses(10, Vec3(0.6, 0, 0.8)));
    for (const auto& [dialect, from, to] :
         {std::tuple{"fanuc", "J36.869898", "J36.8709"}, std::tuple{"siemens", ",36.8698976,", ",36.8709,"},
          std::tuple{"heidenhain", "SPB+36.8698976", "SPB+36.8709"}}) {
        std::string text = *write_program(path, {.dialect = dialect, .plane = true});
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << text;
        text.replace(at, std::string(from).size(), to);
        EXPECT_THAT(read_program(text, dialect, &path.machine(), kToolLength).error().text(), HasSubstr("the plane leans 0.001"));
    }
}

TEST(Dialects, ATruncatedProgramIsRefusedWithItsLine) {
    const MachinePath path = path_on(*built_in_machine("ac-table-table"), wandering_poses(60, 12));
    std::mt19937 random(5);
    for (const std::string& dialect : dialect_names()) {
        const std::string text = *write_program(path, {.dialect = dialect});
        // Whatever is cut off beyond the last line break.
        for (int k = 0; k < 200; ++k) {
            const std::size_t kept = random() % (text.size() - 2);
            const auto program = read_program(text.substr(0, kept), dialect, &path.machine(), kToolLength);
            ASSERT_FALSE(program) << dialect << " cut at " << kept << " of " << text.size();
            ASSERT_EQ(program.error().code, ErrorCode::unreadable);
            ASSERT_THAT(program.error().text(), HasSubstr("line ")) << dialect;
        }
    }
}

TEST(Dialects, AnyChangedDigitIsFoundOutOrTooSmallToMatter) {
    const Machine machine = *built_in_machine("ac-table-table");
    const MachinePath path = path_on(machine, wandering_poses(80, 13));
    std::mt19937 random(6);
    for (const std::string& dialect : dialect_names()) {
        const std::string text = *write_program(path, {.dialect = dialect});
        const std::size_t begin = text.find("pass 0"), end = text.rfind("pass");
        int found = 0, harmless = 0;
        for (int k = 0; k < 300; ++k) {
            std::string changed = text;
            const std::size_t at = begin + random() % (end - begin);
            if (changed[at] < '0' || changed[at] > '9') continue;
            changed[at] = static_cast<char>('0' + (changed[at] - '0' + 1 + random() % 9) % 10);
            const auto program = read_program(changed, dialect, &machine, kToolLength);
            const auto same = program ? compare_with_path(*program, path) : tl::unexpected(program.error());
            if (!same) {
                ASSERT_THAT(same.error().text(), HasSubstr("line ")) << dialect;
                ++found;
                continue;
            }
            ++harmless;  // feeds, block numbers, pass comments, last decimals
            ASSERT_LE(same->tip, 1e-4);
            ASSERT_LE(same->axis, radians(1e-4));
        }
        EXPECT_GT(found, 60) << dialect << ", harmless " << harmless;
    }
}

struct Bad {
    const char *dialect, *text, *message;
};

TEST(Dialects, WhatAReaderCannotKnowItRefusesWithTheLine) {
    const Machine machine = *built_in_machine("ac-table-table");
    const Bad programs[] = {
        {"fanuc", "%\nO1\nG43.4 H1\nG0 X1. Y1. Z1. A0. C0.\nM30\n", "line 5: the closing % is missing"},
        {"fanuc", "%\nG43.4 H1\n%\n", "line 3: a % before the end"},
        {"fanuc", "G43.4 H1\nG1 X10 Y0. Z0. A0. C0. F100\nM30\n", "line 2: X10 has no decimal point"},
        {"fanuc", "G43.4\nM30\n", "line 1: G43.4 without H"},
        {"fanuc", "G91 G28 Z0.\nM30\n", "line 1: G91 is not a code that is read; incremental"},
        {"fanuc", "G43.5 H1\nG1 X1. Y1. Z1. I0. J0. K2. F10\nM30\n", "line 2: the tool axis (0, 0, 2) has length 2"},
        {"fanuc", "G43.5 H1\nG1 X1. Y1. Z1. A1. K1. F10\nM30\n",
         "line 2: rotary word A while the tool axis is given as a vector"},
        {"fanuc", "G43.4 H1\nG1 X1. Y1. Z1. I0. J0. K1. F10\nM30\n", "line 2: word I has no meaning here"},
        {"fanuc", "G43.5 H1\nG2 X1. Y1. I1. F10\nM30\n", "line 2: G2 is not a code that is read; arcs"},
        {"fanuc", "#1=2\nM30\n", "line 1: variables"},
        {"fanuc", "G43.4 H1\nG1 X1. Y1. Z1. A0. C0.\nM30\n", "line 2: a cutting move without a feed"},
        {"fanuc", "G43.4 H1\nX1. Y1. Z1. A0. C0.\nM30\n", "line 2: axis words without G0 or G1"},
        {"fanuc", "G43.4 H1\nG0 X1. Y1. Z1. A0. C0.\nG49\nG0 X2. Y1. Z1. A0. C0.\nM30\n",
         "line 4: a move after the control's mode"},
        {"fanuc", "G68.2 X1. Y0. Z0. I0. J0. K0.\nM30\n", "line 1: a plane whose origin is moved"},
        {"fanuc", "G0 A0. C0.\nG68.2 I0. J0. K0.\nG0 X1. Y1. Z1.\nM30\n", "line 3: a move in the plane before the tool length"},
        {"fanuc", "G93 G1 X1. Y1. Z1. A0. C0. F2\nX2.\nM30\n", "line 2: G1 in G93 needs an F of its own"},
        {"fanuc", "M30\n", "line 1: the program never states a whole position"},
        {"siemens", "TRAORI\nG1 X1 Y1 Z1 A3=0 B3=0 C3=1 F10\nM30\n", "line 2: neither ORIAXES nor ORIVECT is stated"},
        {"siemens", "TRAORI\nG1 X1 Y1 Z1 A=0 C=0 F10\nM30\n", "line 2: neither ORIAXES nor ORIVECT"},
        {"siemens", "TRAORI\nORIWKS ORIAXES\nG1 X1 Y1 Z1 A=0 C=0 F10\nM30\n", "line 3: rotary words under ORIWKS"},
        {"siemens", "TRAORI\nORIWKS ORIVECT\nG1 X1 Y1 Z1 A3=1 C3=1 F10\nM30\n", "line 3: the tool axis (1, 0, 1) has length"},
        {"siemens", "TRAORI\nORIWKS ORIVECT\nG1 X=R1 F10\nM30\n", "line 3: word X has no number"},
        {"siemens", "TRAORI\nORIWKS ORIVECT\nG1 X=1+2 F10\nM30\n", "line 3: the expression after X is not read"},
        {"siemens", "TRAORI\nORIMKS ORIAXES\nG1 X1 Y1 Z1 A3=0 B3=0 C3=1 F10\nM30\n",
         "line 3: a tool axis (A3 B3 C3) under ORIAXES"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M30\n2 END PGM B MM\n", "line 3: END PGM B MM closes BEGIN PGM A MM"},
        {"siemens", "G91\nM30\n", "line 1: G91"},
        {"siemens", "CYCLE800(0,\"\",0,27,0,0,0,0,1,0,0,0,0,1)\nM30\n", "line 1: CYCLE800 in mode 27"},
        {"siemens", "CYCLE800(0,\"\",0,57\nM30\n", "line 1: CYCLE800 without its brackets"},
        {"siemens", "GOTOF LABEL\nM30\n", "line 1: \"GOTOF\" is not read"},
        {"siemens", "TRAORI\nORIMKS ORIAXES\nG0 X1 Y1 Z1 A0 C0\n", "line 3: the program has no end"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M128\n2 L X+1 Y+1 Z+1 A+0 C+0 R0 FMAX\n4 M30\n5 END PGM A MM\n",
         "line 4: block 4 follows block 2: a block is missing"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 L X+1 Y+1 Z+1 R0 FMAX\n2 M30\n3 END PGM A MM\n",
         "line 2: a move of X Y Z without FUNCTION TCPM"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M128\n2 LN X+1 Y+1 Z+1 TX+0 TY+0 TZ+1 R0 FMAX\n",
         "line 3: LN with a tool axis needs FUNCTION TCPM"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\n2 LN X+1 Y+1 TX+0 TY+0 TZ+1 R0 FMAX\n",
         "line 3: LN needs all of"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 FUNCTION TCPM F CONT AXIS POS\n", "line 2: FUNCTION TCPM is read as"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M128\n2 L IX+1 R0 FMAX\n", "line 3: word I has no number"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M128\n2 L X+1,5 R0 FMAX\n", "line 3: the decimal comma after X"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 CC X+1 Y+2\n", "line 2: \"CC X+1 Y+2\" is not read"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 END PGM A MM\n", "line 2: END PGM without M30"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 M30\n", "line 2: END PGM is missing"},
        {"heidenhain", "L X+1\n", "line 1: a block begins with its number"},
        {"heidenhain", "0 BEGIN PGM A MM\n1 PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN FMAX\n",
         "line 2: PLANE SPATIAL is read with STAY"},
    };
    for (const Bad& bad : programs) {
        const auto p = read_program(bad.text, bad.dialect, &machine, 100);
        ASSERT_FALSE(p) << bad.dialect << ":\n" << bad.text;
        EXPECT_EQ(p.error().code, ErrorCode::unreadable);
        EXPECT_THAT(p.error().text(), HasSubstr(bad.message)) << bad.text;
    }
}

TEST(Dialects, WordsAreReadAsTheControlsDo) {
    const Machine machine = *built_in_machine("ac-table-table");
    // Fanuc: a missing one of I J K is zero, all missing keep the axis. Inches, with their feed.
    auto p = read_program("%\nO12\nG20G43.5H1\ng1x1.y2.z3.k1.f10.\nx2.\n(turn)j-1.\nG49\nM30\n%\n", "fanuc", &machine, 100);
    ASSERT_TRUE(p) << p.error().text();
    ASSERT_EQ(p->blocks.size(), 3u);
    EXPECT_LT((p->blocks[1].tip.cl - Vec3(50.8, 50.8, 76.2)).norm(), 1e-13);
    EXPECT_EQ(p->blocks[1].tip.axis, Vec3(0, 0, 1));
    EXPECT_NEAR(p->blocks[1].feed, 10 * 25.4 / 60, 1e-12);
    EXPECT_EQ(p->blocks[2].tip.axis, Vec3(0, -1, 0));
    EXPECT_EQ(p->blocks[2].line, 6);
    EXPECT_EQ(p->interpolation, Interpolation::great_circle);
    // Siemens: addresses with and without the equals sign; comments; messages.
    p = read_program(
        "N10 TRAORI(1) ; on\nORIMKS ORIAXES\nMSG(\"x\")\nN20 g0 x=1 Y2. Z3 A=90 C0\nG1 Y=-2.5 A0 F600\nTRAFOOF\nM17\n", "siemens",
        &machine, 100);
    ASSERT_TRUE(p) << p.error().text();
    ASSERT_EQ(p->blocks.size(), 2u);
    EXPECT_LT((p->blocks[0].tip.axis - Vec3(0, -1, 0)).norm(), 1e-15);
    EXPECT_EQ(p->blocks[1].tip.cl, Vec3(1, -2.5, 3));
    EXPECT_EQ(p->blocks[1].feed, 10);
    EXPECT_EQ(p->interpolation, Interpolation::rotary_axes);
    // Heidenhain: surface normals are passed over, F stays, FMAX holds for one block, M128 in a block.
    p = read_program(
        "0 BEGIN PGM A INCH\n1 TOOL CALL 1 Z S1000\n2 FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\n"
        "3 LN X+1 Y+0 Z+0 NX+0 NY+0 NZ+1 TX+0 TY+0 TZ+1 R0 F60 M3\n4 LN X+2 Y+0 Z+0 TX+0 TY+0.6 TZ+0.8 R0 FMAX ; c\n"
        "5 LN X+3 Y+0 Z+0 TX+0 TY+0.6 TZ+0.8 R0\n6 M30\n7 END PGM A INCH\n",
        "heidenhain", &machine, 100);
    ASSERT_TRUE(p) << p.error().text();
    ASSERT_EQ(p->blocks.size(), 3u);
    EXPECT_TRUE(p->blocks[1].rapid);
    EXPECT_FALSE(p->blocks[2].rapid);
    EXPECT_DOUBLE_EQ(p->blocks[2].feed, 25.4);
    EXPECT_DOUBLE_EQ(p->blocks[2].tip.cl.x(), 76.2);
}

TEST(Dialects, AFileOfOnesOwnIsUsedAndItsMistakesAreNamed) {
    const std::string good = R"(title = "Ours"
ending = "min"
syntax = "fanuc"
header = """
%
O7000 ({title})
?tcp G43.4 H{tool}
?spindle S{rpm} M3
"""
footer = """
G49
M30
%
"""
[number]
style = "point"
[block]
number = "N{} "
number_step = 5
cut = "G01"
rapid = "G00"
links = "at-feed"
)";
    const auto folder = std::filesystem::temp_directory_path() / "trunnion-dialect-test";
    std::filesystem::create_directories(folder);
    const std::string file = (folder / "ours.toml").string();
    std::ofstream(file) << good;
    const MachinePath path = path_on(*built_in_machine("ac-table-table"), wandering_poses(60, 14));
    const auto text = write_program(path, {.dialect = file});
    ASSERT_TRUE(text) << text.error().text();
    EXPECT_THAT(*text, HasSubstr("%\nO7000 (Trunnion "));
    EXPECT_THAT(*text, HasSubstr("N10 G43.4 H1\n(pass 0: cut)\nN15 G01 X"));
    EXPECT_EQ(file_ending(file), "min");
    const auto program = read_program(*text, file, &path.machine(), kToolLength);
    ASSERT_TRUE(program) << program.error().text();
    EXPECT_TRUE(compare_with_path(*program, path));
    std::filesystem::remove_all(folder);

    const auto replaced = [&](std::string_view from, std::string_view to) {
        std::string changed = good;
        changed.replace(changed.find(from), from.size(), to);
        return dialect_from_toml(changed, "ours.toml").error().text();
    };
    EXPECT_THAT(replaced("{rpm}", "{speed}"), HasSubstr("ours.toml:4: header has the placeholder \"{speed}\""));
    EXPECT_THAT(replaced("?tcp", "?tpc"), HasSubstr("ours.toml:4: header has a line under the condition \"tpc\""));
    EXPECT_THAT(replaced("\"fanuc\"", "\"fanuk\""),
                HasSubstr("ours.toml:3: syntax = \"fanuk\" is not known; did you mean \"fanuc\"?"));
    EXPECT_THAT(replaced("rapid =", "rapids ="), HasSubstr("block.rapid is missing"));
    EXPECT_THAT(replaced("number_step = 5", "number_step = 0"), HasSubstr("block.number_step must be a whole number from 1"));
    EXPECT_THAT(find_dialect("nowhere.toml").error().text(), HasSubstr("nowhere.toml"));
}

}  // namespace
}  // namespace trunnion
