// An axis that winds up: the tool goes out, the axis winds back, and the plan is valid.
#include <gtest/gtest.h>

#include <regex>

#include <nlohmann/json.hpp>

#include "run_program.hpp"

namespace {

using namespace cli_tests;

TEST(Rewind, IsInsertedWhereTheAxisRunsOutOfTravelAndThePlanIsProved) {
    const Folder folder;
    std::string machine = slurp(std::string(TRUNNION_SOURCE_DIR) + "/data/machines/ac-table-table.toml");
    machine = std::regex_replace(machine, std::regex("travel_deg = \\[-36000, 36000\\]"), "travel_deg = [-200, 200]");
    folder.write("machine.toml", machine);
    folder.write("job.toml", R"([part]
surface = { kind = "sphere", radius_mm = 40, patch_uv = [0.0, 6.283185307, 0.5, 0.7] }
[cutter]
shape = "ball"
diameter_mm = 10
[path]
pattern = "isoparametric"
passes = 3
zigzag = false
[machine]
file = "machine.toml"
)");
    const Finished run = run_trunnion("plan " + (folder / "job.toml").string() + " -o " + (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.out << run.err;
    EXPECT_NE(run.err.find("rewinds: the tool goes out"), std::string::npos) << run.err;
    // From the file alone: C inside its travel, no step of a rotary axis that was not cut small, and the check holds again.
    const auto plan = nlohmann::json::parse(slurp(folder / "out/plan.json"));
    const auto& positions = plan["machine"]["positions"];
    double least = 1e9, most = -1e9, step = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        least = std::min(least, positions[i][4].get<double>());
        most = std::max(most, positions[i][4].get<double>());
        if (i > 0) step = std::max(step, std::abs(positions[i][4].get<double>() - positions[i - 1][4].get<double>()));
    }
    EXPECT_GE(least, -200);
    EXPECT_LE(most, 200);
    EXPECT_LT(step, 30);
    EXPECT_TRUE(std::isfinite(plan["metrics"]["time_dynamic_s"].get<double>()));
    EXPECT_EQ(run_trunnion("check " + (folder / "out/plan.json").string() + " --quiet").exit, 0);
}

TEST(SingularPole, IsGoneRoundWhereTheJobAsksAndNothingGouges) {
    const Folder folder;
    std::string machine = slurp(std::string(TRUNNION_SOURCE_DIR) + "/data/machines/ac-table-table.toml");
    machine = std::regex_replace(machine, std::regex("travel_deg = \\[-120, 120\\]"), "travel_deg = [-0.5, 120]");
    folder.write("machine.toml", machine);
    // Passes over the top of a dome, the tool along the normal: the middle ones go through the pole or close by.
    folder.write("job.toml", R"([part]
surface = { kind = "dome", height_mm = 12, a_mm = 30, b_mm = 30, patch_uv = [-18.0, 18.0, -12.0, 12.1] }
[cutter]
shape = "ball"
diameter_mm = 10
[path]
pattern = "isoparametric"
passes = 5
[machine]
file = "machine.toml"
)");
    nlohmann::json metrics[2];
    for (const int k : {0, 1}) {
        const Finished run = run_trunnion("plan " + (folder / "job.toml").string() + " --quiet --json -o " +
                                          (folder / "out").string() + (k == 1 ? " --set machine.singularity=adapt" : ""));
        ASSERT_EQ(run.exit, 0) << k << run.out << run.err;
        metrics[k] = nlohmann::json::parse(run.out)["metrics"];
    }
    std::printf("    least sine %.4f -> %.4f, time %.1f -> %.1f s\n", metrics[0]["least_singularity_sine"].get<double>(),
                metrics[1]["least_singularity_sine"].get<double>(), metrics[0]["time_dynamic_s"].get<double>(),
                metrics[1]["time_dynamic_s"].get<double>());
    EXPECT_LT(metrics[0]["least_singularity_sine"].get<double>(), 0.02);
    EXPECT_LT(metrics[1]["time_dynamic_s"].get<double>(), metrics[0]["time_dynamic_s"].get<double>());
}

}  // namespace
