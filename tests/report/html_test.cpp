#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/assets.hpp"
#include "report/facts.hpp"
#include "report/scene_data.hpp"
#include "report/synthetic_plan.hpp"
#include "report/text.hpp"
#include "trunnion/report/html.hpp"

namespace trunnion {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

struct Job {
    PlanDocument plan;
    Part part;
    Mesh vise;
    std::string title = "Wavy block";

    explicit Job(const synthetic::Options& options)
        : plan(synthetic::plan(options)), part(synthetic::wavy_block(options.grid)), vise(synthetic::vise()) {}
    std::string page() const {
        ReportInput input;
        input.plan = &plan;
        input.part = &part;
        input.machined_faces = {0};
        input.check_bodies = {{"vise.stl", &vise}};
        input.tool = synthetic::tool();
        input.title = title;
        return report_html(input);
    }
};
const synthetic::Options kSmall{.passes = 2, .poses_per_pass = 20, .grid = 6};

/// The page without the scripts that are code: what is left is markup, style and data.
std::string without_code(std::string page) {
    for (const std::string_view code : {report::three_js(), report::orbit_controls_js(), report::viewer_js()}) {
        const std::size_t at = page.find(code);
        EXPECT_NE(at, std::string::npos);
        if (at != std::string::npos) page.erase(at, code.size());
    }
    return page;
}

std::size_t count_of(const std::string& text, std::string_view word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

TEST(ReportPage, SaysThatAValidPlanIsValidAndWhatWasProved) {
    const std::string page = Job(kSmall).page();
    EXPECT_THAT(page, HasSubstr("<p class=\"word\">VALID</p>"));
    EXPECT_THAT(page, HasSubstr("&lt;= 0.001 mm on the exact surfaces"));
    EXPECT_THAT(page, HasSubstr("convex tree, certified"));
}

TEST(ReportPage, SaysWhyAPlanIsNotValidAndWhere) {
    synthetic::Options options = kSmall;
    options.bad_first = 10;
    options.bad_count = 3;
    const std::string page = Job(options).page();
    EXPECT_THAT(page, HasSubstr("<p class=\"word\">NOT VALID</p>"));
    EXPECT_THAT(
        page,
        HasSubstr("3 of 58 poses are not valid. The first is pose 10 in pass 1 (cut): holder 1 comes 0.42 mm into vise.stl"));
    EXPECT_THAT(page, HasSubstr("data-pose=\"10\">Poses 10–12, pass 1</button>"));
    EXPECT_THAT(page, HasSubstr("Check failed: shank and holder &gt;= 1 mm"));
}

TEST(ReportPage, LoadsNothingFromAnywhere) {
    const std::string page = without_code(Job(kSmall).page());
    EXPECT_THAT(page, Not(HasSubstr("http://")));
    EXPECT_THAT(page, Not(HasSubstr("https://")));
    EXPECT_THAT(page, Not(HasSubstr("src=")));
    EXPECT_EQ(count_of(page, "href="), 1u);  // the empty icon, which stops browsers from asking for one
    EXPECT_THAT(page, HasSubstr("href=\"data:,\""));
    EXPECT_THAT(page, Not(HasSubstr("@import")));
    EXPECT_THAT(page, Not(HasSubstr("url(")));
    EXPECT_THAT(page, HasSubstr("default-src 'none'"));
    for (const char* call : {"fetch(", "XMLHttpRequest", "WebSocket", "import(", "new Worker"})
        EXPECT_THAT(std::string(report::viewer_js()), Not(HasSubstr(call)));
}

TEST(ReportPage, KeepsTheLicenceOfThree) {
    const std::string page = Job(kSmall).page();
    EXPECT_THAT(page, HasSubstr("Copyright (c) 2010-2019 three.js authors"));
    EXPECT_THAT(page, HasSubstr("The above copyright notice and this permission notice shall be included"));
}

TEST(ReportPage, EscapesEveryTextThatComesFromOutside) {
    const std::string evil = "</script><script>window.pwned=1</script><img src=x onerror=alert(1)>\"'&";
    synthetic::Options options = kSmall;
    options.bad_first = 10;
    options.bad_count = 2;
    Job job(options);
    const std::size_t scripts = count_of(job.page(), "<script");
    job.title = job.part.file = job.plan.machine_name = job.plan.trunnion = evil;
    job.plan.axes.assign(5, evil);
    job.plan.why[10] = evil;
    job.plan.warnings = {evil};
    job.plan.checks = {{evil, evil, evil, false}};
    job.plan.timings_s = {{evil, 1.0}};
    job.plan.job_json = "{\"cutter\": {\"shape\": " + report::json_string(evil) + "}}";
    job.plan.metrics_json = "{" + report::json_string(evil) + ": " + report::json_string(evil) + "}";
    const std::string page = without_code(job.page());
    EXPECT_EQ(count_of(page, "<script"), scripts);
    EXPECT_EQ(count_of(page, "</script"), scripts);
    EXPECT_EQ(count_of(page, "<img"), 0u);
    EXPECT_GE(count_of(page, "&lt;script&gt;window.pwned=1"), 10u);
    EXPECT_GE(count_of(page, "\\u003cscript>window.pwned=1"), 2u);  // the same text as data for the viewer
}

TEST(ReportPage, IsWholeForAPlanWithoutAnything) {
    PlanDocument plan;
    ReportInput input;
    input.plan = &plan;
    const std::string page = report_html(input);
    EXPECT_THAT(page, HasSubstr("NOT VALID"));
    EXPECT_THAT(page, HasSubstr("The plan has no poses."));
    EXPECT_THAT(page, HasSubstr("</html>"));
}

TEST(Verdict, NeedsPosesThatWereAllCheckedAndARunThatEnded) {
    PlanDocument plan = synthetic::plan(kSmall);
    EXPECT_TRUE(report::judge(plan).valid());
    plan.interrupted = true;
    EXPECT_THAT(report::judge(plan).reasons, ElementsAre("The run was interrupted: this is a partial result."));
    plan = synthetic::plan(kSmall);
    plan.valid.clear();
    EXPECT_THAT(report::judge(plan).reasons, ElementsAre("The poses were not checked."));
    plan = synthetic::plan(kSmall);
    plan.valid[57] = 0;
    EXPECT_THAT(report::judge(plan).reasons,
                ElementsAre("1 of 58 poses is not valid. It is pose 57 in pass 6 (lead-out): no reason was recorded."));
}

TEST(Facts, GroupBadPosesByRunAndReason) {
    PlanDocument plan = synthetic::plan(kSmall);
    for (const std::size_t i : {3u, 4u, 5u, 9u}) plan.valid[i] = 0;
    plan.why[3] = plan.why[4] = "a";
    plan.why[5] = "b";
    plan.why[9] = "b";
    const auto runs = report::bad_runs(plan);
    ASSERT_EQ(runs.size(), 3u);
    EXPECT_EQ(runs[0].first, 3u);
    EXPECT_EQ(runs[0].count, 2u);
    EXPECT_EQ(runs[1].why, "b");
    EXPECT_EQ(runs[2].first, 9u);
}

TEST(Facts, MeasurePathAndAxes) {
    PlanDocument plan;
    plan.passes = {{0, 1, "lead-in"}, {1, 3, "cut"}, {4, 1, "link"}};
    plan.cl = {{0, 0, 0}, {0, 0, 2}, {3, 0, 2}, {3, 4, 2}, {3, 4, 12}};
    plan.axis.assign(5, Vec3::UnitZ());
    plan.axes = {"X", "Y", "Z", "A", "C"};
    plan.positions = {{0, 0, 0, 10, 0}, {0, 0, 2, 20, 0}, {3, 0, 2, -5, 0}, {3, 4, 2, 0, 0}, {3, 4, 12, 0, 0}};
    plan.time_s = {0, 1, 3, 3, 4};
    const auto lengths = report::lengths_of(plan);
    EXPECT_DOUBLE_EQ(lengths.all, 2 + 3 + 4 + 10);
    EXPECT_DOUBLE_EQ(lengths.cut, 3 + 4);
    const auto axes = report::axis_use(plan);
    ASSERT_EQ(axes.size(), 5u);
    EXPECT_FALSE(axes[2].rotary);
    EXPECT_TRUE(axes[3].rotary);
    EXPECT_DOUBLE_EQ(axes[3].lo, -5);
    EXPECT_DOUBLE_EQ(axes[3].hi, 20);
    EXPECT_DOUBLE_EQ(axes[3].travel, 10 + 25 + 5);
    EXPECT_DOUBLE_EQ(axes[3].speed_per_min, 60 * 12.5);  // 25 deg in 2 s; the 5 deg took no time and say nothing
    plan.time_s[4] = 2;                                  // a clock that runs backwards is none
    EXPECT_FALSE(report::clock_of(plan).is_time);
    EXPECT_DOUBLE_EQ(report::clock_of(plan).at.back(), 19);
}

TEST(Shading, KeepsEveryTriangleWhereItWasAndSplitsOnlyAtCreases) {
    const Part part = synthetic::wavy_block(8);
    const Vec3 origin = part.box.centre();
    const report::ShadedMesh shaded = report::shade(part.mesh, origin);
    ASSERT_EQ(shaded.indices.size(), 3 * part.mesh.triangles.size());
    for (std::size_t t = 0; t < part.mesh.triangles.size(); ++t) {
        const auto& triangle = part.mesh.triangles[t];
        const Vec3 facet = (part.mesh.vertices[triangle[1]] - part.mesh.vertices[triangle[0]])
                               .cross(part.mesh.vertices[triangle[2]] - part.mesh.vertices[triangle[0]])
                               .normalized();
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t v = shaded.indices[3 * t + k];
            const Vec3 p(shaded.positions[3 * v], shaded.positions[3 * v + 1], shaded.positions[3 * v + 2]);
            EXPECT_LT((p + origin - part.mesh.vertices[triangle[k]]).norm(), 1e-5);  // float ulp at 100 mm
            const Vec3 n = Vec3(shaded.normals[3 * v], shaded.normals[3 * v + 1], shaded.normals[3 * v + 2]) / 32767.0;
            EXPECT_NEAR(n.norm(), 1, 1e-4);
            EXPECT_GT(n.dot(facet),
                      std::cos(radians(56.0)));  // within one crease angle of its copy's mean, which is within one of it
        }
    }
    // An inner vertex of a side has one normal, the 8 corners of the block three, the rest of the sharp edges two.
    std::size_t wavy_only = 0;
    for (const std::uint32_t face : part.mesh.face) wavy_only += face == 0;
    EXPECT_EQ(wavy_only, 2u * 8 * 8);
    EXPECT_LT(shaded.positions.size() / 3, 3 * part.mesh.vertices.size());
}

TEST(Shading, DrawsTheEdgesOfABoxAndNotItsDiagonals) {
    Mesh box;
    synthetic::add_box(box, {0, 0, 0}, {1, 2, 3}, 0);
    const report::ShadedMesh shaded = report::shade(box, Vec3::Zero());
    EXPECT_EQ(shaded.positions.size() / 3, 24u);  // 8 corners, 3 normals each
    ASSERT_EQ(shaded.edges.size(), 2u * 12);
    for (std::size_t e = 0; e < 12; ++e) {
        int differing = 0;
        for (std::size_t k = 0; k < 3; ++k)
            differing += shaded.positions[3 * shaded.edges[2 * e] + k] != shaded.positions[3 * shaded.edges[2 * e + 1] + k];
        EXPECT_EQ(differing, 1);
    }
}

TEST(Text, Base64AgreesWithTheStandardsExamples) {  // RFC 4648, section 10
    const auto encoded = [](std::string_view text) { return report::base64(std::as_bytes(std::span(text))); };
    EXPECT_EQ(encoded(""), "");
    EXPECT_EQ(encoded("f"), "Zg==");
    EXPECT_EQ(encoded("fo"), "Zm8=");
    EXPECT_EQ(encoded("foo"), "Zm9v");
    EXPECT_EQ(encoded("foob"), "Zm9vYg==");
    EXPECT_EQ(encoded("fooba"), "Zm9vYmE=");
    EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
    EXPECT_EQ(encoded("\xff\xfe\xfd"), "//79");
}

}  // namespace
}  // namespace trunnion
