// The resolved job in plan.json is the job: read back, it gives the same one.
#include <gtest/gtest.h>

#include "run_program.hpp"
#include "trunnion/job.hpp"

namespace {

using namespace trunnion;

void expect_round_trip(const std::string& toml) {
    const auto job = job_from_toml(toml, "/tmp/job.toml");
    ASSERT_TRUE(job) << job.error().text();
    const std::string json = job_to_json(*job);
    const auto back = job_from_json(json, "/tmp/plan.json");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(job_to_json(*back), json);
}

TEST(Job, SurvivesTheWayThroughItsResolvedForm) {
    expect_round_trip(cli_tests::dome_job());
    expect_round_trip(
        "[part]\nfile = \"a.step\"\nfaces = [1, 2]\nflip_normal = true\ncheck = [\"v.stl\"]\n"
        "[cutter]\nshape = \"apt\"\ndiameter_mm = 10\ncorner_mm = 1\nalpha_deg = 5\nbeta_deg = 3\nflute_mm = 20\n"
        "shank = { diameter_mm = 10, length_mm = 20 }\nholder = [ { bottom_mm = 20, top_mm = 30, length_mm = 40 } ]\n"
        "[path]\npattern = \"parallel\"\ndirection_deg = 30\ndrop_axis = [0, 0.6, 0.8]\npositions_mm = [1, 2, 3.5]\nstep_mm = 2\n"
        "[orientation]\nlead_deg = 5\ntilt_deg = -7.25\n[links]\nsurface = \"cylinder\"\nradius_mm = 80\nlow = false\n"
        "[machine]\nname = \"ab-head-head\"\nwork_offset_mm = [1, 2, 3]\n[program]\ntcp = false\nspindle_rpm = 12000\n");
    expect_round_trip(
        "[part]\nsurface = { kind = \"bspline\", degree = [1, 1], knots_u = [0, 0, 1, 1], knots_v = [0, 0, 1, 1], control = "
        "[[[0,0,0],[0,1,0]],[[1,0,0],[1,1,0.1]]], "
        "weights = [[1, 2], [1, 1]], patch_uv = [0.1, 0.9, 0.2, 0.8] }\n[cutter]\nshape = \"conical\"\ndiameter_mm = "
        "12\ncorner_mm = 2\nbarrel_radius_mm = 80\nflute_mm = 25\n");
    const std::string flat = "[part]\nfile = \"a.step\"\n[cutter]\ndiameter_mm = 4\n[path]\n";
    expect_round_trip(flat + "pattern = \"curve\"\nuv = [[0, 0.1], [0.5, 0.25], [1, 0.3]]\nstep_mm = 2\n");
    expect_round_trip(flat + "pattern = \"points\"\nxy = [[0, 0.1], [0.5, 0.25]]\ndrop_axis = [0, 0.6, 0.8]\n");
    const std::string modes = "[part]\nfile = \"a.step\"\n[cutter]\ndiameter_mm = 4\n[orientation]\nmethod = ";
    expect_round_trip(modes + "\"rmf\"\nvariant = \"II\"\ninclination_deg = \"auto\"\nyaw_deg = 12.5\nclose_loops = true\n");
    expect_round_trip(modes + "\"vector\"\naxis = [0.6, 0, 0.8]\n");
    expect_round_trip(modes + "\"point\"\npoint_mm = [1, 2, 3]\nside = \"away\"\n");
    expect_round_trip(modes + "\"line\"\npoint_mm = [1, 2, 3]\ndirection = [0, 1, 0]\n");
    expect_round_trip(modes + "\"curve\"\ncurve_mm = [[1, 2, 3], [4, 5, 6]]\n");
    expect_round_trip(modes + "\"normals\"\nsurface = { kind = \"sphere\", radius_mm = 4, patch_uv = [0, 1, 0.2, 1] }\n");
    expect_round_trip(modes + "\"normals\"\nface = 4\nreversed = true\n");
    expect_round_trip(modes + "\"range\"\nlead_range_deg = [-3, 4]\ntilt_range_deg = [0, 0]\n");
    expect_round_trip(modes + "\"lock\"\nrotary = \"C\"\nangle_deg = 33\nlead_deg = 2\n");
    expect_round_trip(modes + "\"plane\"\nnormal = [0, 1, 0]\ntilt_deg = -7\n");
    expect_round_trip(modes + "\"keys\"\nkeys = [[0, 0, 0, 1], [0.5, 0, 0.6, 0.8]]\n");
    const cli_tests::Folder folder;
    folder.write("p.csv", "# made by hand\nx, y\n1, 2\n\n3; 4.5  # last\n");
    const auto job = job_from_toml(flat + "pattern = \"points\"\nfile = \"p.csv\"\n", folder / "job.toml");
    ASSERT_TRUE(job) << job.error().text();
    const auto& points = std::get<GivenPoints>(job->pattern);
    ASSERT_EQ(points.xy.size(), 2u);
    EXPECT_EQ(points.xy[1], Vec2(3.0, 4.5));
}

TEST(Job, SettingsOverrideTheFile) {
    const auto job =
        job_from_toml(cli_tests::dome_job(), "/tmp/job.toml",
                      {"cutter.diameter_mm=12.5", "links.surface=sphere", "links.radius_mm=99", "program.tcp=false"});
    ASSERT_TRUE(job) << job.error().text();
    EXPECT_EQ(job->cutter.diameter, 12.5);
    EXPECT_EQ(std::get<ClearanceSphere>(*job->clearance_surface).radius, 99.0);
    EXPECT_FALSE(*job->tcp);
}

TEST(Job, EveryWrongValueIsRefusedWithItsKey) {
    const std::string good = cli_tests::dome_job();
    for (const auto& [setting, key] : std::vector<std::pair<std::string, std::string>>{{"cutter.diameter_mm=0", "diameter_mm"},
                                                                                       {"cutter.diameter_mm=nan", "diameter_mm"},
                                                                                       {"cutter.diameter_mm=[1]", "diameter_mm"},
                                                                                       {"cutter.shape=bul", "bull"},
                                                                                       {"path.passes=0", "passes"},
                                                                                       {"path.passes=1.5", "passes"},
                                                                                       {"path.pattern=parralel", "parallel"},
                                                                                       {"orientation.tilt_deg=-90", "tilt_deg"},
                                                                                       {"orientation.method=sturts", "sturz"},
                                                                                       {"tolerance.chord_mm=-1", "chord_mm"},
                                                                                       {"tolerance.gouge_mm=inf", "gouge_mm"},
                                                                                       {"machine.feed_mm_min=0", "feed_mm_min"},
                                                                                       {"program.dialect=linuxnc", "linuxcnc"},
                                                                                       {"part.faces=[-1]", "faces"},
                                                                                       {"part.file=x.step", "surface"},
                                                                                       {"links.lead_mm=0", "lead_mm"},
                                                                                       {"path.pattern=curve", "uv"},
                                                                                       {"orientation.method=vector", "axis"},
                                                                                       {"orientation.method=normals", "face"},
                                                                                       {"orientation.method=keys", "keys"},
                                                                                       {"part=3", "part"}}) {
        const auto job = job_from_toml(good, "/tmp/job.toml", {setting});
        ASSERT_FALSE(job) << setting;
        EXPECT_EQ(job.error().code, ErrorCode::invalid_input);
        EXPECT_NE(job.error().text().find(key), std::string::npos) << setting << " -> " << job.error().text();
    }
}

}  // namespace
