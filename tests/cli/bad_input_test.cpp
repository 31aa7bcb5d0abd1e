// Bad input: one clear sentence, exit code 2, nothing written.
#include <gtest/gtest.h>

#include <sys/mount.h>

#include "run_program.hpp"

namespace {

using namespace cli_tests;

/// Plans the job text and expects a refusal that mentions every one of `words` in one line, with nothing written.
void expect_refusal(const std::string& job, const std::vector<std::string>& words, const Folder& folder) {
    const fs::path file = folder.write("job.toml", job);
    const Finished run = run_trunnion("plan " + file.string() + " --quiet -o " + (folder / "result").string());
    EXPECT_EQ(run.exit, 2) << run.err;
    EXPECT_TRUE(run.out.empty()) << run.out;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    for (const std::string& word : words)
        EXPECT_NE(run.err.find(word), std::string::npos) << "\"" << word << "\" is not in: " << run.err;
    EXPECT_TRUE(!fs::exists(folder / "result") || fs::is_empty(folder / "result"));
}

std::string part_job(const std::string& file) {
    return "[part]\nfile = \"" + file + "\"\nfaces = [0]\n[cutter]\nshape = \"ball\"\ndiameter_mm = 8\n[path]\npasses = 2\n";
}

TEST(BadInput, MissingPartFileIsNamed) {
    const Folder folder;
    expect_refusal(part_job("nowhere.step"), {"nowhere.step", "no such file"}, folder);
}

TEST(BadInput, MissingJobFileIsNamed) {
    const Finished run = run_trunnion("plan nowhere.toml");
    EXPECT_EQ(run.exit, 2);
    EXPECT_NE(run.err.find("nowhere.toml"), std::string::npos) << run.err;
}

TEST(BadInput, TruncatedStepIsRefused) {
    const Folder folder;
    const std::string whole = slurp(fs::path(TRUNNION_SOURCE_DIR) / "data/parts/compressor_blade.step");
    ASSERT_GT(whole.size(), 100000u);
    folder.write("cut.step", whole.substr(0, whole.size() / 2));
    expect_refusal(part_job("cut.step"), {"cut.step"}, folder);
}

TEST(BadInput, EmptyStlIsRefused) {
    const Folder folder;
    folder.write("empty.stl", "");
    expect_refusal(part_job("empty.stl"), {"empty.stl"}, folder);
    folder.write("none.stl", "solid none\nendsolid none\n");
    expect_refusal(part_job("none.stl"), {"none.stl"}, folder);
}

TEST(BadInput, StlWithNanNamesItsPlace) {
    const Folder folder;
    folder.write(
        "nan.stl",
        "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 nan 0\nendloop\nendfacet\nendsolid x\n");
    expect_refusal(part_job("nan.stl"), {"nan.stl", "6"}, folder);
}

TEST(BadInput, UnknownKeyNamesTheNearestKnownOne) {
    const Folder folder;
    expect_refusal(dome_job("shape = \"ball\"\ndiametre_mm = 8\ndiameter_mm = 8"), {"job.toml:5", "diametre_mm", "diameter_mm"},
                   folder);
}

TEST(BadInput, UnknownTableNamesTheNearestKnownOne) {
    const Folder folder;
    expect_refusal(dome_job() + "[tolerances]\nchord_mm = 0.1\n", {"tolerances", "tolerance"}, folder);
}

TEST(BadInput, NegativeDiameterIsRefused) {
    const Folder folder;
    expect_refusal(dome_job("shape = \"ball\"\ndiameter_mm = -8"), {"diameter_mm", "-8", "job.toml:5"}, folder);
}

TEST(BadInput, CornerRadiusAboveHalfTheDiameterIsRefused) {
    const Folder folder;
    expect_refusal(dome_job("shape = \"bull\"\ndiameter_mm = 8\ncorner_mm = 4.5"), {"corner_mm", "4.5", "4"}, folder);
}

TEST(BadInput, FaceIndexOutOfRangeNamesTheRange) {
    const Folder folder;
    const std::string blade = fs::path(TRUNNION_SOURCE_DIR) / "data/parts/compressor_blade.step";
    expect_refusal("[part]\nfile = \"" + blade + "\"\nfaces = [99]\n[cutter]\nshape = \"ball\"\ndiameter_mm = 8\n",
                   {"99", "0 to 17"}, folder);
}

TEST(BadInput, LeadOf95DegreesIsRefused) {
    const Folder folder;
    expect_refusal(
        "[part]\nsurface = { kind = \"sphere\", radius_mm = 20 }\n[cutter]\ndiameter_mm = 8\n[orientation]\nlead_deg = 95\n",
        {"lead_deg", "95", "job.toml:6"}, folder);
}

TEST(BadInput, MachineFileWithAZeroAxisIsRefused) {
    const Folder folder;
    std::string machine = slurp(fs::path(TRUNNION_SOURCE_DIR) / "data/machines/ac-table-table.toml");
    const std::size_t axis = machine.find("[1, 0, 0]", machine.find("[[rotary]]"));
    ASSERT_NE(axis, std::string::npos);
    machine.replace(axis, 9, "[0, 0, 0]");
    folder.write("machine.toml", machine);
    expect_refusal(dome_job() + "[machine]\nfile = \"machine.toml\"\n", {"machine.toml", "zero axis"}, folder);
}

TEST(BadInput, UnwritableOutputFolderIsRefusedBeforeTheWork) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job());
    folder.write("file", "");
    const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + (folder / "file").string());
    EXPECT_EQ(run.exit, 2);
    EXPECT_NE(run.err.find("file"), std::string::npos) << run.err;
    const Finished proc = run_trunnion("plan " + job.string() + " --quiet -o /proc/trunnion");
    EXPECT_EQ(proc.exit, 2) << proc.err;
}

TEST(BadInput, FullDiscKeepsWhatWasThere) {
    if (::geteuid() != 0) GTEST_SKIP() << "needs root to mount a small file system";
    const Folder folder;
    const fs::path small = folder / "small";
    fs::create_directory(small);
    if (::mount("tmpfs", small.c_str(), "tmpfs", 0, "size=64k") != 0) GTEST_SKIP() << "cannot mount a small file system here";
    std::ofstream(small / "plan.json") << "old";
    const fs::path job = folder.write("job.toml", dome_job());
    const Finished run = run_trunnion("plan " + job.string() + " --quiet -o " + small.string());
    const std::string kept = slurp(small / "plan.json");
    const auto entries = std::distance(fs::directory_iterator(small), fs::directory_iterator());
    ::umount(small.c_str());
    EXPECT_EQ(run.exit, 2) << run.err;
    EXPECT_NE(run.err.find("No space left"), std::string::npos) << run.err;
    EXPECT_EQ(kept, "old");
    EXPECT_EQ(entries, 1);
}

TEST(BadInput, BrokenTomlNamesTheLine) {
    const Folder folder;
    expect_refusal("[part]\nfile = \n", {"job.toml:2", "TOML"}, folder);
}

TEST(BadInput, SettingsAreCheckedLikeTheFile) {
    const Folder folder;
    const fs::path job = folder.write("job.toml", dome_job());
    const Finished run =
        run_trunnion("plan " + job.string() + " --quiet --set cutter.diameter_mm=-1 -o " + (folder / "r").string());
    EXPECT_EQ(run.exit, 2);
    EXPECT_NE(run.err.find("diameter_mm"), std::string::npos) << run.err;
    const Finished unknown =
        run_trunnion("plan " + job.string() + " --quiet --set cutter.diamter_mm=1 -o " + (folder / "r").string());
    EXPECT_EQ(unknown.exit, 2);
    EXPECT_NE(unknown.err.find("did you mean \"diameter_mm\""), std::string::npos) << unknown.err;
}

TEST(BadInput, UnknownOptionAndMissingCommandExitWithTwo) {
    EXPECT_EQ(run_trunnion("plan --nonsense").exit, 2);
    EXPECT_EQ(run_trunnion("").exit, 2);
    EXPECT_EQ(run_trunnion("list nonsense").exit, 2);
    EXPECT_EQ(run_trunnion("--help").exit, 0);
}

}  // namespace
