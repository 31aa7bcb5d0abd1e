// Opens the page in a real browser from disk and reads what the page says about itself (selfTest in viewer.js).
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/synthetic_plan.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/report/html.hpp"

namespace trunnion {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class Browser : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::system("command -v chromium > /dev/null 2>&1") != 0)
            GTEST_SKIP() << "chromium is not installed: the page was not opened";
        std::string pattern = (fs::temp_directory_path() / "trunnion-report-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override {
        std::error_code ignored;
        if (!folder_.empty()) fs::remove_all(folder_, ignored);
    }

    /// The document after its scripts ran; the browser's own messages are kept in `console_`.
    std::string open(const std::string& page, const std::string& size, const std::string& flags = "") {
        std::ofstream(folder_ / "report.html", std::ios::binary) << page;
        const std::string command =
            "timeout 120 chromium --headless --no-sandbox --disable-quic --no-first-run --disable-background-networking"
            " --disable-component-update --disable-sync --hide-scrollbars --virtual-time-budget=8000 --enable-logging=stderr "
            "--window-size=" +
            size + " --user-data-dir=" + (folder_ / "profile").string() + " " + flags + " --dump-dom 'file://" +
            (folder_ / "report.html").string() + "#selftest' > " + (folder_ / "dom").string() + " 2> " +
            (folder_ / "messages").string();
        EXPECT_EQ(std::system(command.c_str()), 0);
        console_ = read_file(folder_ / "messages").value();
        return read_file(folder_ / "dom").value();
    }

    /// data-NAME of the document element.
    static std::string says(const std::string& dom, const std::string& name) {
        const std::string root = dom.substr(0, dom.find('>', dom.find("<html")));
        std::smatch match;
        return std::regex_search(root, match, std::regex("data-" + name + "=\"([^\"]*)\"")) ? match[1].str() : "(nothing)";
    }
    void expect_no_errors(const std::string& dom) const {
        EXPECT_EQ(says(dom, "errors"), "[]");
        EXPECT_THAT(console_, Not(HasSubstr("Uncaught")));
        EXPECT_THAT(console_, Not(HasSubstr("ERROR:CONSOLE")));
        EXPECT_THAT(console_, Not(HasSubstr("THREE.")));
        EXPECT_THAT(console_, Not(HasSubstr("Content Security Policy")));
    }

    fs::path folder_;
    std::string console_;
};

struct Job {
    PlanDocument plan;
    Part part = synthetic::wavy_block(60);
    Mesh vise = synthetic::vise();
    ReportInput input;
    explicit Job(const synthetic::Options& options) : plan(synthetic::plan(options)) {
        input.plan = &plan;
        input.part = &part;
        input.machined_faces = {0};
        input.check_bodies = {{"vise.stl", &vise}};
        input.tool = synthetic::tool();
        input.title = "Wavy block, finishing";
    }
};
const synthetic::Options kOneBadPose{.passes = 2, .poses_per_pass = 1000, .grid = 60, .bad_first = 700, .bad_count = 1};

TEST_F(Browser, DrawsThePartMovesTheToolAndFindsTheProblemAtEveryWindowSize) {
    const Job job(kOneBadPose);
    const std::string page = report_html(job.input);
    for (const std::string size : {"1280,900", "800,1200", "400,800"}) {
        SCOPED_TRACE(size);
        const std::string dom = open(page, size);
        EXPECT_EQ(says(dom, "ready"), "ok");
        expect_no_errors(dom);
        EXPECT_GT(std::atoi(says(dom, "colours").c_str()), 100);  // a blank canvas has 1, a flat silhouette fewer than 20
        EXPECT_GT(std::atoi(says(dom, "plot-colours").c_str()), 20);
        EXPECT_EQ(says(dom, "tool-moved"), "true");
        EXPECT_GT(std::atof(says(dom, "cursor-moved").c_str()), 50);  // pixels, half of the plot
        EXPECT_EQ(says(dom, "picked"), "0");                          // a click on the tip at pose 0
        EXPECT_EQ(says(dom, "problem-pose"), "700");
        EXPECT_THAT(dom, HasSubstr("holder 1 comes 0.42 mm into vise.stl"));
    }
}

TEST_F(Browser, WorksWithoutWebGlExceptForThePicture) {
    const Job job(kOneBadPose);
    const std::string dom =
        open(report_html(job.input), "1280,900", "--disable-gpu --disable-software-rasterizer --disable-3d-apis");
    EXPECT_EQ(says(dom, "ready"), "no-webgl");
    EXPECT_EQ(says(dom, "errors"), "[]");
    EXPECT_THAT(dom, HasSubstr("The 3-D picture cannot be drawn"));
    EXPECT_GT(std::atoi(says(dom, "plot-colours").c_str()), 20);
    EXPECT_EQ(says(dom, "problem-pose"), "700");
}

TEST_F(Browser, OpensAPlanWithoutPosesOrPart) {
    const PlanDocument plan;
    ReportInput input;
    input.plan = &plan;
    const std::string dom = open(report_html(input), "1280,900");
    EXPECT_EQ(says(dom, "ready"), "ok");
    expect_no_errors(dom);
}

TEST_F(Browser, RunsNoScriptThatComesFromAName) {
    synthetic::Options options{.passes = 2, .poses_per_pass = 20, .grid = 6, .bad_first = 10, .bad_count = 1};
    Job job(options);
    const std::string evil =
        "</script><script>document.documentElement.dataset.pwned='yes'</script><img src=x "
        "onerror=\"document.documentElement.dataset.pwned='yes'\">";
    job.input.title = job.part.file = job.plan.machine_name = evil;
    job.plan.why[10] = evil;
    job.plan.axes.assign(5, evil);
    job.plan.warnings = {evil};
    job.input.check_bodies[0].name = evil;
    job.input.tool.pieces[0].name = evil;
    const std::string dom = open(report_html(job.input), "1280,900");
    EXPECT_EQ(says(dom, "ready"), "ok");
    EXPECT_EQ(says(dom, "pwned"), "(nothing)");
    expect_no_errors(dom);
}

}  // namespace
}  // namespace trunnion
