// Jobs with orientation.method = "multipoint": what the plan file holds, and what is refused.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "run_program.hpp"
#include "support/vcrf_surfaces.hpp"
#include "trunnion/job.hpp"
#include "trunnion/pose/multipoint.hpp"

namespace {

using namespace cli_tests;
using nlohmann::json;

std::string saddle_job(const std::string& path, const std::string& orientation = "", const std::string& cutter = "") {
    json rows = json::array();
    for (const auto& row : trunnion::vcrf_control(trunnion::VcrfSurface::saddle)) {
        rows.push_back(json::array());
        for (const trunnion::Vec3& p : row) rows.back().push_back({p.x(), p.y(), p.z()});
    }
    return "[part]\nsurface = { kind = \"bezier\", control = " + rows.dump() +
           " }\n[cutter]\nshape = \"bull\"\ndiameter_mm = 25.4\ncorner_mm = 6\nflute_mm = 40\n" + cutter + "\n[path]\n" + path +
           "\n[orientation]\nmethod = \"multipoint\"\n" + orientation + "\n[machine]\nname = \"ac-table-table\"\n";
}

const char* const kRow = "pattern = \"parallel\"\ndirection_deg = 90\npositions_mm = [72]\nstep_mm = 3\n";

TEST(MultipointPlan, HoldsThePosesOfTheSolverAtGivenFootprints) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", saddle_job("pattern = \"points\"\nxy = [[72, 40], [72, 40.5], [72, 41]]"));
    const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.out << run.err;
    const json plan = json::parse(slurp(folder / "out" / "plan.json")), poses = plan["poses"];
    const auto solver = trunnion::MultipointSolver::build(trunnion::vcrf_surface(trunnion::VcrfSurface::saddle),
                                                          trunnion::vcrf_cutter(false), {});
    std::size_t found = 0;
    for (std::size_t i = 0; i < poses["status"].size(); ++i) {
        if (poses["status"][i] == "") {
            EXPECT_TRUE(poses["second_contact"][i].is_null());
            EXPECT_TRUE(poses["safe_tilt_deg"][i].is_null());
            continue;
        }
        const auto p = solver->drop(72.0, 40.0 + 0.5 * static_cast<double>(found++), trunnion::Vec3::UnitY());
        ASSERT_TRUE(p.has_value());
        EXPECT_EQ(poses["status"][i], std::string(trunnion::name_of(p->status)));
        EXPECT_EQ(poses["z_c"][i].get<double>(), p->z_c);
        EXPECT_EQ(poses["tilt_about_insert_deg"][i].get<double>(), trunnion::degrees(p->tilt));
        EXPECT_EQ(poses["safe_tilt_deg"][i][1].get<double>(), trunnion::degrees(p->tilt_plus));
        for (int k = 0; k < 3; ++k) {
            EXPECT_EQ(poses["cl"][i][k].get<double>(), p->CL[k]);
            EXPECT_EQ(poses["axis"][i][k].get<double>(), p->T[k]);
            EXPECT_EQ(poses["second_contact"][i][k].get<double>(), p->Q[k]);
        }
        EXPECT_LT(poses["gouge_mm"][i].get<double>(),
                  1.1e-4);  // what the independent check proves by default: a tenth of gouge_mm
    }
    EXPECT_EQ(found, 3u);
    EXPECT_EQ(run_trunnion("check " + (folder / "out" / "plan.json").string() + " --quiet").exit, 0);
    // The resolved job in the plan is the same job.
    const auto again = trunnion::job_from_json(plan["job"].dump(), "again");
    ASSERT_TRUE(again.has_value()) << again.error().text();
    EXPECT_EQ(json::parse(trunnion::job_to_json(*again)), plan["job"]);
}

TEST(MultipointPlan, LimitsTheStepOfTheTiltAndStaysClear) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", saddle_job(kRow, "max_step_deg = 0.05\nmax_tilt_deg = 9"));
    const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + (folder / "out").string());
    ASSERT_EQ(run.exit, 0) << run.out << run.err;
    const json poses = json::parse(slurp(folder / "out" / "plan.json"))["poses"];
    double last = -1.0;
    int limited = 0;
    for (std::size_t i = 0; i < poses["status"].size(); ++i) {
        if (poses["status"][i] == "") continue;
        const double tilt = poses["tilt_about_insert_deg"][i].get<double>(), plus = poses["safe_tilt_deg"][i][1].get<double>();
        EXPECT_LE(tilt, plus);
        EXPECT_LE(tilt, 9.0 + 1e-9);
        if (last >= 0.0) {
            EXPECT_LE(std::abs(tilt - last), 0.05 + 1e-9);
        }
        limited += tilt < plus - 1e-9;
        last = tilt;
    }
    EXPECT_GT(limited, 3);
}

TEST(MultipointPlan, OrientsGivenContactsToo) {
    const Folder folder;
    for (const char* lean : {"lean = \"drop-axis\"", "yaw_deg = 40", "lean = \"separation\""}) {
        const fs::path job =
            folder.write("job.toml", saddle_job("pattern = \"curve\"\nuv = [[0.4, 0.4], [0.45, 0.45], [0.5, 0.5]]",
                                                std::string(lean) + "\nstart_deg = 20", "bottom = \"open\""));
        const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + (folder / "out").string());
        EXPECT_EQ(run.exit, 0) << lean << run.out << run.err;
        const json poses = json::parse(slurp(folder / "out" / "plan.json"))["poses"];
        for (std::size_t i = 0; i < poses["status"].size(); ++i)
            if (poses["status"][i] == "TwoContacts") {
                EXPECT_LT(poses["separation_mm"][i].get<double>(), 13.9) << lean;
            }  // 2 Ro + 2 Ri sin(alpha)
    }
}

TEST(MultipointPlan, SaysWhatIsWrongAndLeavesWithTwo) {
    const Folder folder;
    const auto refused = [&](const std::string& text, const std::string& says) {
        const fs::path job = folder.write("job.toml", text);
        const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + (folder / "out").string());
        EXPECT_EQ(run.exit, 2) << run.out << run.err;
        EXPECT_NE(run.err.find(says), std::string::npos) << run.err;
    };
    refused(saddle_job("pattern = \"points\"\nxy = [[72, 40], [720, 40]]"), "NoSurfaceUnderTool at footprint (720, 40)");
    refused(saddle_job("pattern = \"parallel\""), "path.side_step_mm or path.positions_mm is missing");
    refused(saddle_job(kRow, "max_tilt_deg = 120"), "max_tilt_deg");
    refused(saddle_job(kRow, "max_tild_deg = 20"), "max_tilt_deg");
    refused(saddle_job(kRow, "lead_deg = 20"), "lead_deg");
    std::string flat = saddle_job(kRow);
    flat.replace(flat.find("\"bull\""), 6, "\"flat\"");
    flat.replace(flat.find("corner_mm = 6\n"), 14, "");
    refused(flat, "multipoint\" needs");
}

}  // namespace
