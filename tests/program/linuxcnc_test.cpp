// The real thing: LinuxCNC's interpreter, planner and kinematics run what we write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include <nlohmann/json.hpp>

#include <fmt/format.h>
#include <unistd.h>

#include "support/linuxcnc.hpp"
#include "support/machine_path.hpp"
#include "trunnion/machine/timing.hpp"
#include "trunnion/program/program.hpp"

#ifndef TRUNNION_LINUXCNC_RUN
#define TRUNNION_LINUXCNC_RUN TRUNNION_SOURCE_DIR "/../shared/clients/linuxcnc-run"
#endif

namespace trunnion {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Outcome {
    int exit_code = -1;
    std::vector<json> lines;
    std::string errors;
    json summary;
};

class Linuxcnc : public testing::Test {
protected:
    void SetUp() override {
        if (const auto why = why_no_linuxcnc(TRUNNION_LINUXCNC_RUN)) GTEST_SKIP() << *why;
        folder_ = fs::temp_directory_path() / fmt::format("trunnion-linuxcnc-{}", getpid());
        fs::create_directories(folder_);
    }
    void TearDown() override {
        if (!folder_.empty()) fs::remove_all(folder_);
    }
    Outcome run(const std::string& arguments, const std::string& program) {
        const fs::path file = folder_ / "program.ngc";
        std::ofstream(file) << program;
        Outcome result;
        FILE* pipe = popen(
            fmt::format("/usr/bin/python3 {} {} {} 2>/dev/null", TRUNNION_LINUXCNC_RUN, arguments, file.string()).c_str(), "r");
        if (!pipe) return result;
        std::string text;
        char buffer[65536];
        for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
        result.exit_code = WEXITSTATUS(pclose(pipe));
        std::istringstream in(text);
        for (std::string line; std::getline(in, line);) {
            json item = json::parse(line, nullptr, false);
            if (item.is_discarded()) continue;
            if (item["type"] == "error") result.errors += line + '\n';
            if (item["type"] == "summary") result.summary = item;
            result.lines.push_back(std::move(item));
        }
        return result;
    }

    /// Runs the program of a path and compares the joints at the end of each block with ours.
    void expect_same_joints(const MachinePath& path, bool tcp, const std::string& arguments, double linear, double angle) {
        const Machine& machine = path.machine();
        ASSERT_TRUE(path.valid());
        const auto text = write_program(path, {.tcp = tcp});
        ASSERT_TRUE(text) << text.error().text();
        const auto program = read_program(*text, "linuxcnc", &machine, kToolLength);
        ASSERT_TRUE(program) << program.error().text();
        ASSERT_TRUE(compare_with_path(*program, path));
        const Outcome done = run(arguments, *text);
        ASSERT_EQ(done.exit_code, 0) << done.errors;
        std::map<int, json> joints;
        for (const json& line : done.lines)
            if (line["type"] == "block") joints[line["line"].get<int>()] = line["joints"];
        double worst_linear = 0, worst_rotary = 0;
        for (std::size_t i = 0; i < path.poses().size(); ++i) {
            const int line = program->blocks[i].line;
            ASSERT_TRUE(joints.contains(line)) << "pose " << i << ", line " << line;
            for (int j = 0; j < 5; ++j) {
                const std::string letter(1, j < 3 ? machine.linear[j].letter : machine.rotary[j - 3].letter);
                const double theirs = joints[line][letter].get<double>();
                const double ours = j < 3 ? path.joints()[i][j] : degrees(path.joints()[i][j]);
                (j < 3 ? worst_linear : worst_rotary) = std::max(j < 3 ? worst_linear : worst_rotary, std::abs(theirs - ours));
            }
        }
        EXPECT_LT(worst_linear, linear);
        EXPECT_LT(worst_rotary, angle);
        std::printf("    largest difference: %.2e mm, %.2e deg over %zu poses\n", worst_linear, worst_rotary,
                    path.poses().size());
    }

    static inline const std::string kTool = fmt::format("--fast --tool 1:{}:10 ", kToolLength);
    fs::path folder_{};
};

TEST_F(Linuxcnc, RunsXyzacProgramsToOurJointPositions) {
    Machine machine = *built_in_machine("linuxcnc-xyzac-trt");
    machine.rotary[1].point = {5, 6, -4};                                 // C
    machine.rotary[0].point = machine.rotary[1].point + Vec3(0, 20, 10);  // A
    expect_same_joints(
        path_on(machine, wandering_poses(250, 21)), true,
        kTool + "--set x-rot-point=5 --set y-rot-point=6 --set z-rot-point=-4 --set y-offset=20 --set z-offset=10 xyzac", 1e-5,
        1e-7);
}

TEST_F(Linuxcnc, RunsXyzbcProgramsToOurJointPositions) {
    Machine machine = *built_in_machine("linuxcnc-xyzbc-trt");
    machine.rotary[0].point = {-15, 0, 30};  // B
    expect_same_joints(path_on(machine, wandering_poses(250, 22)), true, kTool + "--set x-offset=-15 --set z-offset=30 xyzbc",
                       1e-5, 1e-7);
}

TEST_F(Linuxcnc, Runs5axisProgramsToOurJointPositions) {
    const Machine machine = *built_in_machine("linuxcnc-5axis");
    expect_same_joints(path_on(machine, wandering_poses(250, 23)), true,
                       kTool + fmt::format("--set pivot-length={} 5axis", 250 + kToolLength), 1e-5, 1e-7);
}

TEST_F(Linuxcnc, RunsMachinePositionsWithInverseTime) {
    const Machine machine = *built_in_machine("ac-table-table");
    expect_same_joints(path_on(machine, wandering_poses(250, 24), false), false, kTool + "id:XYZAC", 1e-5, 1e-7);
}

TEST_F(Linuxcnc, ReadsThePositionsAndFeedsThatWeMeant) {
    const MachinePath path = path_on(*built_in_machine("linuxcnc-xyzac-trt"), wandering_poses(5000, 25));
    const auto text = write_program(path, {});
    ASSERT_TRUE(text);
    const auto program = read_program(*text, "linuxcnc", &path.machine(), kToolLength);
    ASSERT_TRUE(program);
    const Outcome done = run("read", *text);
    ASSERT_EQ(done.exit_code, 0) << done.errors;
    std::map<int, json> moves;
    for (const json& line : done.lines)
        if (line["type"] == "move") moves[line["line"].get<int>()] = line;
    for (std::size_t i = 0; i < path.poses().size(); ++i) {
        const ProgramBlock& block = program->blocks[i];
        // The interpreter counts lines from zero in some releases and from one in others: it must be the same for all.
        const auto found = moves.find(block.line);
        ASSERT_NE(found, moves.end()) << "line " << block.line;
        const json& pos = found->second["pos"];
        for (int j = 0; j < 3; ++j)
            ASSERT_NEAR(pos[std::string(1, "XYZ"[j])].get<double>(), path.poses().cl[i][j], 1e-6) << "pose " << i;
        ASSERT_NEAR(pos["A"].get<double>(), degrees(path.joints()[i][3]), 1e-6);
        ASSERT_NEAR(pos["C"].get<double>(), degrees(path.joints()[i][4]), 1e-6);
        ASSERT_EQ(found->second["rapid"].get<bool>(), block.rapid);
        const double feed = block.rapid ? path.feed()[i] * 60.0 : found->second["feed"].get<double>();
        ASSERT_NEAR(feed / (path.feed()[i] * 60.0), 1.0, 1e-5) << "pose " << i;
    }
}

TEST_F(Linuxcnc, RefusesAProgramBeyondTheTravelAsWeDo) {
    Machine machine = *built_in_machine("ac-table-table");
    const MachinePath free = path_on(machine, wandering_poses(120, 26), false);
    double least = 1e9;
    for (const JointPosition& q : free.joints()) least = std::min(least, q[2]);
    machine.linear[2].limits.lo = least + 0.5;
    const MachinePath limited = path_on(machine, wandering_poses(120, 26), false);
    EXPECT_FALSE(limited.valid());
    EXPECT_FALSE(write_program(limited, {.tcp = false}));
    const auto text = write_program(limited, {.tcp = false, .allow_invalid = true});
    ASSERT_TRUE(text);
    const Outcome done = run(kTool + fmt::format("--limit Z={:.6f}:1000 --home Z=500 id:XYZAC", least + 0.5), *text);
    EXPECT_EQ(done.exit_code, 3) << done.errors;
}

TEST_F(Linuxcnc, PlannedTimeOfInverseTimeProgramsIsKept) {
    // Feeds that the axes can follow: no faster than planned, and slower only by acceleration and short blocks.
    const Machine machine = *built_in_machine("ac-table-table");
    PosePath poses = wandering_poses(60, 27);
    poses.passes = {{0, 60, PassKind::cut, false}};
    const MachinePath path = path_on(machine, poses, false);
    const auto text = write_program(path, {.tcp = false});
    ASSERT_TRUE(text);
    const Outcome done = run(fmt::format("--tool 1:{} --vel X=500 --vel Y=500 --vel Z=500 --vel A=150 --vel C=240 --acc X=50000 "
                                         "--acc Y=50000 --acc Z=50000 --acc A=50000 --acc C=50000 id:XYZAC",
                                         kToolLength),
                             *text);
    ASSERT_EQ(done.exit_code, 0) << done.errors;
    const auto program = read_program(*text, "linuxcnc", &machine, kToolLength);
    double begin = -1, end = -1;
    for (const json& line : done.lines) {
        if (line["type"] != "block") continue;
        if (line["line"].get<int>() == program->blocks.front().line) begin = line["t1"].get<double>();
        if (line["line"].get<int>() == program->blocks.back().line) end = line["t1"].get<double>();
    }
    ASSERT_GT(begin, 0);
    const double ratio = (end - begin) / path.totals().time;
    std::printf("    LinuxCNC %.3f s, planned %.3f s\n", end - begin, path.totals().time);
    EXPECT_GT(ratio, 0.97);
    EXPECT_LT(ratio, 1.25);
    // The same limits under our own dynamics. At a tenth of these accelerations LinuxCNC takes far longer, because with rotary
    // words each of its blocks must be able to stop; that says as much of the length of blocks as of the machine.
    Machine limited = machine;
    for (LinearAxis& axis : limited.linear) axis.limits.velocity = 500, axis.limits.acceleration = 50000;
    limited.rotary[0].limits.velocity = radians(150);
    limited.rotary[1].limits.velocity = radians(240);
    for (RotaryAxis& axis : limited.rotary) axis.limits.acceleration = radians(50000);
    const auto timing = time_motion(path_on(limited, poses, false), {}, {});
    ASSERT_TRUE(timing);
    std::printf("    LinuxCNC / time under accelerations: %.4f\n", (end - begin) / timing->total);
    EXPECT_NEAR((end - begin) / timing->total, 1.0, 0.05);
}

}  // namespace
}  // namespace trunnion
