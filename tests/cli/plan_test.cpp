// The main job from the command line: outputs, exit codes, collisions, interruption, kills.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <random>
#include <thread>

#include <fcntl.h>
#include <nlohmann/json.hpp>

#include "run_program.hpp"

namespace {

using namespace cli_tests;
using nlohmann::json;

TEST(PlanCommand, WritesAllFourFilesAndTheyCheckOut) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job()), out = folder / "out";
    const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + out.string());
    ASSERT_EQ(run.exit, 0) << run.err << run.out;
    for (const char* name : {"plan.json", "path.cls", "program.ngc", "report.html"}) EXPECT_TRUE(fs::exists(out / name)) << name;
    EXPECT_NE(run.out.find("VALID"), std::string::npos);

    const Finished plan_check = run_trunnion("check " + (out / "plan.json").string() + " --quiet");
    EXPECT_EQ(plan_check.exit, 0) << plan_check.out << plan_check.err;
    for (const char* name : {"path.cls", "program.ngc"}) {
        const Finished check = run_trunnion("check " + (out / name).string() + " --quiet --json --job " + job.string());
        EXPECT_EQ(check.exit, 0) << name << check.out << check.err;
        EXPECT_TRUE(json::parse(check.out)["valid"].get<bool>());
    }
}

TEST(PlanCommand, JsonIsOneObjectOnStandardOutput) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job());
    const Finished run = run_trunnion("plan " + job.string() + " --json -o " + (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.err;
    const json j = json::parse(run.out);
    EXPECT_TRUE(j["valid"].get<bool>());
    EXPECT_EQ(j["files"].size(), 4u);
    EXPECT_GT(j["metrics"]["poses"].get<int>(), 10);
}

TEST(PlanCommand, SameJobSameBytesForOneAndTwoThreads) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job());
    for (const char* threads : {"1", "2"})
        ASSERT_EQ(
            run_trunnion("plan " + job.string() + " --quiet --threads " + threads + " -o " + (folder / threads).string()).exit,
            0);
    for (const char* name : {"path.cls", "program.ngc"})
        EXPECT_EQ(slurp(folder / "1" / name), slurp(folder / "2" / name)) << name;
    json a = json::parse(slurp(folder / "1" / "plan.json")), b = json::parse(slurp(folder / "2" / "plan.json"));
    a.erase("timings_s");
    b.erase("timings_s");
    EXPECT_EQ(a, b);
}

/// A wall beside the dome that a holder runs into.
std::string wall_stl() {
    std::string s = "solid wall\n";
    const auto facet = [&](const char* a, const char* b, const char* c) {
        s += std::string("facet normal 0 0 0\nouter loop\nvertex ") + a + "\nvertex " + b + "\nvertex " + c +
             "\nendloop\nendfacet\n";
    };
    facet("0 -40 12", "0 40 12", "0 40 90");
    facet("0 -40 12", "0 40 90", "0 -40 90");
    return s + "endsolid wall\n";
}

TEST(PlanCommand, CollisionExitsThreeNamesThePosesAndWritesNoProgram) {
    const Folder folder;
    folder.write("wall.stl", wall_stl());
    std::string job = dome_job(
        "shape = \"ball\"\ndiameter_mm = 8\nflute_mm = 20\nholder = [ { bottom_mm = 40, top_mm = 50, length_mm = 40 } ]");
    job.insert(job.find("[cutter]"), "check = [\"wall.stl\"]\n");
    const fs::path file = folder.write("job.toml", job), out = folder / "out";
    fs::create_directory(out);
    std::ofstream(out / "program.ngc") << "(an old program)\n";  // must not stay beside an invalid plan
    const Finished run = run_trunnion("plan " + file.string() + " --quiet -o " + out.string());
    EXPECT_EQ(run.exit, 3) << run.err;
    EXPECT_NE(run.out.find("holder 1"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("wall.stl"), std::string::npos) << run.out;
    EXPECT_FALSE(fs::exists(out / "program.ngc"));
    EXPECT_FALSE(fs::exists(out / "path.cls"));
    EXPECT_TRUE(fs::exists(out / "report.html"));
    const json plan = json::parse(slurp(out / "plan.json"));
    std::size_t bad = 0;
    for (std::size_t i = 0; i < plan["poses"]["valid"].size(); ++i)
        if (!plan["poses"]["valid"][i].get<bool>()) {
            ++bad;
            EXPECT_FALSE(plan["poses"]["why"][i].get<std::string>().empty());
        }
    EXPECT_GT(bad, 0u);
    EXPECT_EQ(bad, plan["metrics"]["invalid_poses"].get<std::size_t>());
    EXPECT_EQ(run_trunnion("check " + (out / "plan.json").string() + " --quiet").exit, 3);

    const Finished forced = run_trunnion("plan " + file.string() + " --quiet --allow-invalid -o " + out.string());
    EXPECT_EQ(forced.exit, 3);
    const std::string program = slurp(out / "program.ngc");
    EXPECT_NE(program.find("INVALID"), std::string::npos);
}

TEST(PlanCommand, ATamperedPlanIsFoundOut) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job()), out = folder / "out";
    ASSERT_EQ(run_trunnion("plan " + job.string() + " --quiet -o " + out.string()).exit, 0);
    json plan = json::parse(slurp(out / "plan.json"));
    for (const auto& pass : plan["passes"])
        if (pass[2] == "cut")
            plan["poses"]["cl"][pass[0].get<std::size_t>() + 1][2] =
                plan["poses"]["cl"][pass[0].get<std::size_t>() + 1][2].get<double>() - 0.05;
    std::ofstream(out / "tampered.json") << plan.dump();
    const Finished run = run_trunnion("check " + (out / "tampered.json").string() + " --quiet");
    EXPECT_EQ(run.exit, 3) << run.out << run.err;
    EXPECT_NE(run.out.find("deep"), std::string::npos) << run.out;
}

pid_t start(const fs::path& job, const fs::path& out) {
    const pid_t pid = ::fork();
    if (pid != 0) return pid;
    const int null = ::open("/dev/null", O_WRONLY);
    ::dup2(null, STDOUT_FILENO);
    ::dup2(null, STDERR_FILENO);
    ::execl(TRUNNION_PROGRAM, "trunnion", "plan", job.c_str(), "--quiet", "-o", out.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
}

int wait_for(pid_t pid) {
    int status = 0;
    ::waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

TEST(PlanCommand, KilledAtRandomMomentsLeavesNoHalfWrittenFile) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job()), out = folder / "out";
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(wait_for(start(job, out)), 0);
    const double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::mt19937 random(20);
    // A run that was over before it was killed was timed on a slower moment of the machine: aim earlier from then on. Moments
    // crowd towards the end, where files are written.
    double longest = whole;
    int killed = 0;
    for (int attempt = 0; attempt < 200 && killed < 20; ++attempt) {
        fs::remove_all(out);
        const pid_t pid = start(job, out);
        std::this_thread::sleep_for(
            std::chrono::duration<double>(longest * std::sqrt(std::uniform_real_distribution<double>(0.0, 1.0)(random))));
        ::kill(pid, SIGKILL);
        if (wait_for(pid) == 128 + SIGKILL) {
            ++killed;
        } else {
            longest *= 0.95;
        }
        if (!fs::exists(out)) continue;
        for (const auto& entry : fs::directory_iterator(out)) {
            const std::string name = entry.path().filename().string(), content = slurp(entry.path());
            if (name.find("plan.json") != std::string::npos) {
                EXPECT_TRUE(json::accept(content)) << name;
            }
            if (name.find("program.ngc") != std::string::npos) {
                EXPECT_NE(content.find("M2"), std::string::npos) << name;
            }
            if (name.find("path.cls") != std::string::npos) {
                EXPECT_NE(content.find("FINI"), std::string::npos) << name;
            }
            if (name.find("report.html") != std::string::npos) {
                EXPECT_NE(content.find("</html>"), std::string::npos) << name;
            }
        }
        // Whoever finds plan.json finds everything: it is named last.
        if (fs::exists(out / "plan.json")) {
            EXPECT_TRUE(fs::exists(out / "program.ngc") && fs::exists(out / "path.cls") && fs::exists(out / "report.html"));
        }
    }
    EXPECT_EQ(killed, 20) << "the test must catch the program at work";
}

TEST(PlanCommand, AnInterruptedRunSaysSoAndExits130) {
    const Folder folder;
    // Long enough to be caught: fine passes.
    std::string text = dome_job();
    text.replace(text.find("passes = 6"), 10, "passes = 3000");
    const fs::path job = folder.write("job.toml", text), out = folder / "out";
    const pid_t pid = start(job, out);
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    ::kill(pid, SIGINT);
    EXPECT_EQ(wait_for(pid), 130);
    EXPECT_FALSE(fs::exists(out / "plan.json"));
    EXPECT_FALSE(fs::exists(out / "program.ngc"));
    if (fs::exists(out / "plan.partial.json")) {
        const json partial = json::parse(slurp(out / "plan.partial.json"));
        EXPECT_TRUE(partial["interrupted"].get<bool>());
        EXPECT_EQ(run_trunnion("check " + (out / "plan.partial.json").string()).exit, 2);
    }
}

TEST(ListCommand, NamesEverythingTheBuildKnows) {
    EXPECT_NE(run_trunnion("list methods").out.find("sturz"), std::string::npos);
    EXPECT_NE(run_trunnion("list patterns").out.find("parallel"), std::string::npos);
    EXPECT_NE(run_trunnion("list machines").out.find("linuxcnc-xyzac-trt"), std::string::npos);
    EXPECT_NE(run_trunnion("list cutters").out.find("tangential"), std::string::npos);
    EXPECT_EQ(json::parse(run_trunnion("list dialects --json").out)["dialects"].size(), 13u);
}

}  // namespace
