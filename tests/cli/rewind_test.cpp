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

}  // namespace
