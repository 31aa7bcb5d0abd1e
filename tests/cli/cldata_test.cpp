// The path of another system, oriented anew.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include <nlohmann/json.hpp>

#include "run_program.hpp"

namespace {

using namespace cli_tests;
using nlohmann::json;

std::string job(const std::string& cutter, const std::string& path, double lead) {
    return "[part]\nsurface = { kind = \"torus\", major_mm = 60, minor_mm = 25, patch_uv = [0.1, 0.9, 0.6, 2.4] }\n[cutter]\n" +
           cutter + "\n[path]\n" + path + "\n[orientation]\nlead_deg = " + std::to_string(lead) + "\n";
}
const std::string kOwn = "pattern = \"isoparametric\"\npasses = 4\nstep_mm = 2";

/// Tips and axes of the cutting poses that touch.
std::vector<std::vector<double>> contacts(const json& plan, const char* what) {
    std::vector<std::vector<double>> all;
    for (std::size_t i = 0; i < plan["poses"]["cc"].size(); ++i)
        if (!plan["poses"]["cc"][i].is_null() && !plan["poses"]["cc"][i][0].is_null())
            all.push_back(plan["poses"][what][i].get<std::vector<double>>());
    return all;
}

TEST(Cldata, TheContactsOfAPathAreFoundAgainAndOrientedAnew) {
    for (const std::string cutter : {"shape = \"ball\"\ndiameter_mm = 8", "shape = \"bull\"\ndiameter_mm = 10\ncorner_mm = 2"}) {
        const Folder folder;
        folder.write("own.toml", job(cutter, kOwn, 12));
        ASSERT_EQ(run_trunnion("plan " + (folder / "own.toml").string() + " --quiet -o " + (folder / "own").string()).exit, 0);
        const json own = json::parse(slurp(folder / "own/plan.json"));
        // From CLDATA and from an NC program; the same lean, and another.
        for (const auto& [file, lead] :
             {std::pair{"own/path.cls", 12.0}, std::pair{"own/program.ngc", 12.0}, std::pair{"own/path.cls", 25.0}}) {
            folder.write("again.toml", job(cutter, "pattern = \"cldata\"\nfile = \"" + std::string(file) + "\"", lead));
            const Finished run =
                run_trunnion("plan " + (folder / "again.toml").string() + " --quiet -o " + (folder / "again").string());
            ASSERT_EQ(run.exit, 0) << file << run.out << run.err;
            const json again = json::parse(slurp(folder / "again/plan.json"));
            const auto before = contacts(own, "cc"), after = contacts(again, "cc");
            double worst = 0;
            std::size_t found = 0;
            for (const auto& a : before) {
                double nearest = 1e9;
                for (const auto& b : after) nearest = std::min(nearest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
                if (nearest < 0.2) ++found, worst = std::max(worst, nearest);
            }
            EXPECT_EQ(found, before.size()) << file;
            EXPECT_LT(worst, 0.05) << file;
            std::printf("    %s: %zu of %zu contacts found, within %.4f mm\n", file, found, before.size(), worst);
        }
    }
}

TEST(Cldata, WhatDoesNotFitIsRefusedWithOneSentence) {
    const Folder folder;
    const std::string ball = "shape = \"ball\"\ndiameter_mm = 8";
    const auto refusal = [&](const std::string& content) {
        folder.write("in.cls", content);
        folder.write("job.toml", job(ball, "pattern = \"cldata\"\nfile = \"in.cls\"", 5));
        const Finished run = run_trunnion("plan " + (folder / "job.toml").string() + " --quiet -o " + (folder / "out").string());
        EXPECT_EQ(run.exit, 2) << run.out;
        return run.err;
    };
    EXPECT_NE(refusal("MULTAX/ON\nGOTO/0,0,500,0,0,1\nGOTO/1,0,500\nFINI\n").find("none of its 2 poses comes within 0.1 mm"),
              std::string::npos);
    EXPECT_NE(refusal("MULTAX/ON\nGOTO/0,0,500,0,0\nFINI\n").find("in.cls: line 2: GOTO needs three numbers"), std::string::npos);
    EXPECT_NE(refusal("MULTAX/ON\nGOTO/0,0,500,0,0,1\n").find("line 2: the file has no FINI"), std::string::npos);
    folder.write("job.toml", job(ball, "pattern = \"cldata\"", 5));
    EXPECT_NE(run_trunnion("plan " + (folder / "job.toml").string()).err.find("path.file is missing"), std::string::npos);
}

}  // namespace
