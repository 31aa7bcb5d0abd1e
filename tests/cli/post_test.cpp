// trunnion post: a plan's program again, for another machine and other controls.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.hpp"

namespace {

using namespace cli_tests;

const char* const kDome = R"([part]
surface = { kind = "sphere", radius_mm = 40, patch_uv = [0.0, 1.2, 0.3, 0.8] }
[cutter]
shape = "ball"
diameter_mm = 10
[path]
pattern = "isoparametric"
passes = 4
)";
/// A flat face milled upright: one orientation.
const char* const kFlat = R"([part]
surface = { kind = "plane", size_mm = [40, 30] }
[cutter]
shape = "ball"
diameter_mm = 10
[path]
pattern = "isoparametric"
passes = 4
[orientation]
lead_deg = 20
)";

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(Post, WritesThePlanForEveryControlAndProvesIt) {
    const Folder folder;
    folder.write("job.toml", kDome);
    ASSERT_EQ(run_trunnion("plan " + (folder / "job.toml").string() + " --quiet -o " + (folder / "out").string()).exit, 0);
    const std::string plan = (folder / "out/plan.json").string();
    for (const auto& [dialect, mark] :
         {std::pair{"siemens", "TRAORI"}, std::pair{"siemens-vector", "A3="}, std::pair{"heidenhain", "FUNCTION TCPM"},
          std::pair{"heidenhain-vector", "TX"}, std::pair{"fanuc", "G43.4"}, std::pair{"fanuc-vector", "G43.5"},
          std::pair{"makino", "G5 P10000"}, std::pair{"mitsubishi", "G43.4"}, std::pair{"mikron", "M128"},
          std::pair{"linuxcnc", "G43 H1"}, std::pair{"apt", "GOTO/"}}) {
        const std::string file = (folder / dialect).string();
        const Finished run =
            run_trunnion("post " + plan + " --quiet --machine bc-table-table --dialect " + dialect + " -o " + file);
        EXPECT_EQ(run.exit, 0) << dialect << run.err;
        EXPECT_TRUE(contains(run.out, "read back against the plan")) << run.out;
        EXPECT_TRUE(contains(slurp(file), mark)) << dialect;
    }
    // The program alone on standard output; or one JSON object.
    const Finished text = run_trunnion("post " + plan + " --quiet --dialect fanuc --no-tcp");
    EXPECT_TRUE(text.out.starts_with("%\nO0001")) << text.out;
    EXPECT_TRUE(contains(text.out, "G93"));
    const auto json = nlohmann::json::parse(run_trunnion("post " + plan + " --quiet --dialect siemens --json").out);
    EXPECT_TRUE(json["valid"].get<bool>());
    EXPECT_TRUE(contains(json["program"].get<std::string>(), "ORIAXES"));
    EXPECT_EQ(json["bad"], 0);
}

TEST(Post, RefusesWhatCannotBeDoneWithOneSentence) {
    const Folder folder;
    folder.write("job.toml", kDome);
    ASSERT_EQ(run_trunnion("plan " + (folder / "job.toml").string() + " --quiet -o " + (folder / "out").string()).exit, 0);
    const std::string plan = (folder / "out/plan.json").string();
    for (const auto& [arguments, message] :
         {std::pair{"--machine nix", "no built-in machine \"nix\""}, std::pair{"--dialect sieman", "did you mean \"siemens\"?"},
          std::pair{"--dialect heidenhain --no-tcp", "under tool-centre-point control only"},
          std::pair{"--dialect fanuc --plane", "needs one orientation for the whole path"},
          std::pair{"--dialect none.toml", "none.toml"}}) {
        const Finished run = run_trunnion("post " + plan + " --quiet " + arguments);
        EXPECT_EQ(run.exit, 2) << arguments;
        EXPECT_TRUE(contains(run.err, message)) << run.err;
        EXPECT_TRUE(run.out.empty());
    }
    // A plan whose poses were changed by hand is checked, not believed.
    auto doc = nlohmann::json::parse(slurp(plan));
    const std::size_t middle = doc["poses"]["cl"].size() / 2;
    doc["poses"]["cl"][middle][2] = doc["poses"]["cl"][middle][2].get<double>() - 3;
    folder.write("changed.json", doc.dump());
    const Finished run =
        run_trunnion("post " + (folder / "changed.json").string() + " --quiet -o " + (folder / "bad.nc").string());
    EXPECT_EQ(run.exit, 3) << run.err;
    EXPECT_TRUE(contains(run.err, "pose " + std::to_string(middle))) << run.err;
    EXPECT_FALSE(fs::exists(folder / "bad.nc"));
}

TEST(Post, AFlatFaceIsAProgramInOnePlane) {
    const Folder folder;
    folder.write("job.toml", std::string(kFlat) + "[program]\ndialect = \"siemens\"\nplane = true\n");
    const Finished planned = run_trunnion("plan " + (folder / "job.toml").string() + " --quiet -o " + (folder / "out").string() +
                                          " --set path.zigzag=false");
    ASSERT_EQ(planned.exit, 0) << planned.err;
    EXPECT_TRUE(contains(slurp(folder / "out/program.mpf"), "CYCLE800(0,\"\",0,57"));
    for (const auto& [dialect, mark] :
         {std::pair{"heidenhain", "PLANE SPATIAL"}, std::pair{"fanuc", "G68.2"}, std::pair{"linuxcnc", "G55"}}) {
        const Finished run =
            run_trunnion("post " + (folder / "out/plan.json").string() + " --quiet --plane --dialect " + dialect);
        EXPECT_EQ(run.exit, 0) << run.err;
        EXPECT_TRUE(contains(run.out, mark)) << run.out;
    }
}

}  // namespace
