// Real parts end to end: planned on several machines, checked from the files alone, run by LinuxCNC.
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "run_program.hpp"
#include "support/linuxcnc.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace {

using namespace cli_tests;
using nlohmann::json;

const fs::path kExamples = fs::path(TRUNNION_SOURCE_DIR) / "examples";
const fs::path kShared = TRUNNION_SHARED_PARTS;

/// Plans the job with the settings, expects a valid plan, and checks plan and both programs from the files alone.
void expect_proved(const fs::path& job, const std::string& settings, const fs::path& out) {
    const Finished run = run_trunnion("plan " + job.string() + " --quiet " + settings + " -o " + out.string());
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    EXPECT_EQ(run_trunnion("check --quiet " + (out / "plan.json").string()).exit, 0);
    for (const char* name : {"program.ngc", "path.cls"}) {
        const Finished check = run_trunnion("check --quiet --job " + job.string() + " " + settings + " " + (out / name).string());
        EXPECT_EQ(check.exit, 0) << name << "\n" << check.err << check.out;
    }
}

TEST(RealParts, BladeIsPlannedOnTwoMachines) {
    const Folder folder;
    for (const char* machine : {"ac-table-table", "ab-head-head"})
        expect_proved(kExamples / "blade.toml", std::string("--set path.scallop_mm=0.1 --set machine.name=") + machine,
                      folder / machine);
}

TEST(RealParts, MouldFloorIsPlannedOnTwoMachines) {
    const Folder folder;
    for (const char* machine : {"bc-table-table", "b-head-c-table"})
        expect_proved(kExamples / "mould.toml", std::string("--set path.scallop_mm=0.03 --set machine.name=") + machine,
                      folder / machine);
}

/// A wall of the casting that a short tool's holder cannot reach past a neighbouring lug.
std::string casting_job(int shank) {
    return fmt::format(
        "[part]\nfile = \"{}\"\nfaces = [236]\nchord_mm = 0.05\n"
        "[cutter]\nshape = \"ball\"\ndiameter_mm = 6\nflute_mm = 12\nshank = {{ diameter_mm = 5.9, length_mm = {} }}\n"
        "holder = [ {{ bottom_mm = 26, top_mm = 40, length_mm = 50 }} ]\nclearance_mm = 1\n"
        "[path]\npasses = 5\nmargin_mm = 1\n[orientation]\nlead_deg = 20\n"
        "[tolerance]\ngouge_mm = 0.01\nchord_mm = 0.02\nangle_deg = 5\n",
        (kShared / "nist_ftc_07_asme1_ap242-e2.stp").string(), shank);
}

TEST(RealParts, CastingInInchesIsPlannedWithALongToolAndRefusedWithAShortOne) {
    if (!fs::exists(kShared)) GTEST_SKIP() << "the folder of further parts is not here: " << kShared;
    const Folder folder;
    const fs::path lean = folder.write("long.toml", casting_job(70)), stubby = folder.write("short.toml", casting_job(5));
    for (const char* machine : {"ac-table-table", "bc-table-table"})
        expect_proved(lean, std::string("--set machine.name=") + machine, folder / machine);
    const Finished refused = run_trunnion("plan --quiet " + stubby.string() + " -o " + (folder / "short").string());
    EXPECT_EQ(refused.exit, 3) << refused.err;
    EXPECT_NE(refused.out.find("holder 1"), std::string::npos) << refused.out;
    EXPECT_FALSE(fs::exists(folder / "short" / "program.ngc"));
}

TEST(RealParts, PanelIsTheSameInEveryFormat) {
    if (!fs::exists(kShared)) GTEST_SKIP() << "the folder of further parts is not here: " << kShared;
    const Folder folder;
    for (const char* format : {"step", "igs", "stl"}) {
        const std::string job = fmt::format(
            "[part]\nfile = \"{}\"\nchord_mm = 0.05\n[cutter]\nshape = \"ball\"\ndiameter_mm = 16\n[path]\npattern = "
            "\"parallel\"\nside_step_mm = 40\nmargin_mm = 2\n"
            "[orientation]\nlead_deg = 10\n[links]\nlead_mm = 5\n[tolerance]\nchord_mm = 0.05\ngouge_mm = 0.01\nangle_deg = "
            "3\n[machine]\nname = \"ab-head-head\"\n",
            (kShared / fmt::format("body_panel.{}", format)).string());
        const fs::path file = folder.write(fmt::format("{}.toml", format), job);
        const Finished run = run_trunnion("plan --quiet " + file.string() + " -o " + (folder / format).string());
        EXPECT_EQ(run.exit, 0) << format << run.err << run.out;
    }
    const auto length = [&](const char* format) {
        return json::parse(slurp(folder / format / "plan.json"))["metrics"]["cut_length_mm"].get<double>();
    };
    EXPECT_NEAR(length("igs") / length("step"), 1.0, 1e-3);
    EXPECT_NEAR(length("stl") / length("step"), 1.0, 0.02);  // its triangles are 0.15 mm off, and rough along the border
}

/// Blocks that LinuxCNC ran: line of the file -> joint positions at its end.
std::map<int, json> run_linuxcnc(const std::string& arguments, const fs::path& program, int& exit_code) {
    FILE* pipe = ::popen(
        fmt::format("/usr/bin/python3 {} {} {} 2>/dev/null", TRUNNION_LINUXCNC_RUN, arguments, program.string()).c_str(), "r");
    std::string text;
    char buffer[65536];
    for (std::size_t n; pipe && (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
    exit_code = pipe ? WEXITSTATUS(::pclose(pipe)) : -1;
    std::map<int, json> joints;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        const json item = json::parse(line, nullptr, false);
        if (!item.is_discarded() && item["type"] == "block") joints[item["line"].get<int>()] = item["joints"];
    }
    return joints;
}

/// The program of a plan in LinuxCNC against the axis positions of plan.json.
void expect_linuxcnc_agrees(const fs::path& out, const std::string& machine_name, const std::string& kind,
                            const std::string& extra) {
    const json plan = json::parse(slurp(out / "plan.json"));
    const double length = plan["metrics"]["tool_length_mm"].get<double>();
    const trunnion::Machine machine = *trunnion::built_in_machine(machine_name);
    const auto program = trunnion::read_program(slurp(out / "program.ngc"), "linuxcnc", &machine, length);
    ASSERT_TRUE(program) << program.error().text();
    ASSERT_EQ(program->blocks.size(), plan["poses"]["cl"].size());
    int exit_code = 0;
    const auto joints =
        run_linuxcnc(fmt::format("--fast --tool 1:{}:8 {} {}", length, extra, kind), out / "program.ngc", exit_code);
    ASSERT_EQ(exit_code, 0);
    double worst_linear = 0.0, worst_rotary = 0.0;
    for (std::size_t i = 0; i < program->blocks.size(); ++i) {
        const auto block = joints.find(program->blocks[i].line);
        ASSERT_NE(block, joints.end()) << "pose " << i << ", line " << program->blocks[i].line;
        for (std::size_t k = 0; k < 5; ++k) {
            const double off = std::abs(block->second[plan["machine"]["axes"][k].get<std::string>()].get<double>() -
                                        plan["machine"]["positions"][i][k].get<double>());
            (k < 3 ? worst_linear : worst_rotary) = std::max(k < 3 ? worst_linear : worst_rotary, off);
        }
    }
    std::printf("    %zu poses, largest difference %.2e mm, %.2e deg\n", program->blocks.size(), worst_linear, worst_rotary);
    EXPECT_LT(worst_linear, 1e-3);
    EXPECT_LT(worst_rotary, 1e-3);
}

class LinuxcncRunsThePlan : public ::testing::Test {
protected:
    void SetUp() override {
        if (const auto why = trunnion::why_no_linuxcnc(TRUNNION_LINUXCNC_RUN)) GTEST_SKIP() << *why;
    }
};

TEST_F(LinuxcncRunsThePlan, OfTheBladeUnderToolCentrePointControl) {
    const Folder folder;
    const Finished run =
        run_trunnion("plan --quiet " + (kExamples / "blade.toml").string() +
                     " --set path.scallop_mm=1 --set machine.name=linuxcnc-xyzac-trt -o " + (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    expect_linuxcnc_agrees(folder / "out", "linuxcnc-xyzac-trt", "xyzac", "");
}

TEST_F(LinuxcncRunsThePlan, OfTheMouldInJointPositionsWithInverseTime) {
    const Folder folder;
    const Finished run = run_trunnion("plan --quiet " + (kExamples / "mould.toml").string() +
                                      " --set path.scallop_mm=0.5 --set program.tcp=false --set tolerance.chord_mm=0.05 -o " +
                                      (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    expect_linuxcnc_agrees(folder / "out", "bc-table-table", "id:XYZBC", "");
}

}  // namespace
