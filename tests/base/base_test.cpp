#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <numeric>

#include <rapidcheck/gtest.h>
#include <unistd.h>

#include "trunnion/base/file.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/base/vec.hpp"

namespace {

using namespace trunnion;
namespace fs = std::filesystem;

double component() {
    return *rc::gen::map(rc::gen::inRange(-1000000, 1000000), [](int i) { return i * 1e-6; });
}
Vec3 direction() {
    const Vec3 v(component(), component(), component());
    RC_PRE(v.norm() > 1e-3);
    return v.normalized();
}

RC_GTEST_PROP(UnitVector, HasUnitLengthAtEveryScale, ()) {
    const Vec3 v = direction();
    for (const double scale : {1e-300, 1e-150, 1.0, 1e150, 1e300}) {
        const auto unit = UnitVector::from(scale * v);
        RC_ASSERT(unit.has_value());
        RC_ASSERT(std::abs(unit->vec().norm() - 1.0) < 7e-16);
        RC_ASSERT((unit->vec() - v).norm() < 1e-15);
    }
}

TEST(UnitVector, RefusesWhatHasNoDirection) {
    const double inf = std::numeric_limits<double>::infinity();
    for (const Vec3& v : {Vec3(0, 0, 0), Vec3(inf, 0, 0), Vec3(std::nan(""), 1, 0), Vec3(1e-320, 0, 0)})
        EXPECT_FALSE(UnitVector::from(v));
}

RC_GTEST_PROP(Slerp, TurnsEvenlyAndStaysUnit, ()) {
    const Vec3 a = direction(), b = direction();
    const double whole = angle_between(a, b);
    RC_PRE(whole < 3.1);
    for (const double t : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const Vec3 c = slerp(a, b, t);
        RC_ASSERT(std::abs(c.norm() - 1.0) < 1e-15);
        RC_ASSERT(std::abs(angle_between(a, c) - t * whole) < 1e-12);
        RC_ASSERT(std::abs(angle_between(c, b) - (1.0 - t) * whole) < 1e-12);
    }
}

TEST(Slerp, AntipodalAxesTurnOnSomeGreatCircle) {
    const Vec3 a(0.6, 0.0, 0.8);
    EXPECT_NEAR(angle_between(a, slerp(a, -a, 0.25)), kPi / 4, 1e-12);
    EXPECT_NEAR(angle_between(-a, slerp(a, -a, 0.75)), kPi / 4, 1e-12);
}

RC_GTEST_PROP(AnyPerpendicular, IsPerpendicularAndUnit, ()) {
    const Vec3 n = direction();
    const Vec3 p = any_perpendicular(n);
    RC_ASSERT(std::abs(p.norm() - 1.0) < 1e-14);
    RC_ASSERT(std::abs(p.dot(n)) < 1e-14);
}

TEST(AnyPerpendicular, IsTheXAxisForZ) {
    EXPECT_NEAR((any_perpendicular(Vec3::UnitZ()) - Vec3::UnitX()).norm(), 0.0, 1e-16);
}

TEST(ParallelFor, CoversEverythingOnceInTheSameChunksForAnyThreads) {
    for (const unsigned threads : {1u, 2u, 3u}) {
        set_threads(threads);
        std::vector<int> hits(1001, 0);
        std::atomic<int> chunks{0};
        ASSERT_TRUE(parallel_for(hits.size(), 64, {}, "test", [&](std::size_t begin, std::size_t end) {
            ++chunks;
            for (std::size_t i = begin; i < end; ++i) ++hits[i];
        }));
        EXPECT_EQ(chunks, 16);
        EXPECT_TRUE(std::all_of(hits.begin(), hits.end(), [](int h) { return h == 1; }));
    }
    set_threads(0);
}

TEST(ParallelFor, StopsWhenCancelledAndSaysSo) {
    std::atomic<bool> cancel{false};
    Control control;
    control.cancel = &cancel;
    std::atomic<int> chunks{0};
    const auto done = parallel_for(100000, 1, control, "long work", [&](std::size_t, std::size_t) {
        if (++chunks == 10) cancel = true;
    });
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::cancelled);
    EXPECT_NE(done.error().message.find("long work"), std::string::npos);
    EXPECT_LT(chunks, 100);
}

TEST(ParallelFor, ReportsProgressThatNeverFalls) {
    double last = 0.0;
    bool falls = false;
    Control control;
    control.progress = [&](std::string_view, double f) { falls = falls || f < last, last = f; };
    ASSERT_TRUE(parallel_for(500, 1, control, "x", [](std::size_t, std::size_t) {}));
    EXPECT_FALSE(falls);
    EXPECT_EQ(last, 1.0);
}

class Files : public ::testing::Test {
protected:
    Files() {
        std::string name = (fs::temp_directory_path() / "trunnion-base-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
    }
    ~Files() override { fs::remove_all(folder_); }
    fs::path folder_;
};

TEST_F(Files, AreWrittenWholeAndReplaceOldOnes) {
    for (const std::string& content : {std::string("first"), std::string(3'000'000, 'x'), std::string()}) {
        ASSERT_TRUE(write_file_atomically(folder_ / "f", content));
        EXPECT_EQ(*read_file(folder_ / "f"), content);
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1) << "no temporary file stays";
}

TEST_F(Files, OfOneSetAreAllOldWhenOneCannotBeWritten) {
    ASSERT_TRUE(write_file_atomically(folder_ / "a", "old"));
    fs::create_directory(folder_ / "b");
    const auto done = write_files_atomically({{folder_ / "a", "new"}, {folder_ / "b", "new"}}, {folder_ / "a"});
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::io);
    EXPECT_EQ(*read_file(folder_ / "a"), "old");
}

TEST_F(Files, ThatAreMissingOrFoldersAreErrors) {
    EXPECT_EQ(read_file(folder_ / "none").error().code, ErrorCode::not_found);
    EXPECT_EQ(read_file(folder_).error().code, ErrorCode::io);
    EXPECT_EQ(write_file_atomically(folder_ / "no" / "such" / "folder", "x").error().code, ErrorCode::io);
}

TEST(NearestWord, FindsTypingErrorsAndForgottenUnits) {
    const std::vector<std::string_view> known{"diameter_mm", "corner_mm", "flute_mm", "lead_deg"};
    EXPECT_EQ(nearest_word("diametre_mm", known), "diameter_mm");
    EXPECT_EQ(nearest_word("lead", known), "lead_deg");
    EXPECT_EQ(nearest_word("corner", known), "corner_mm");
    EXPECT_EQ(nearest_word("xyzzy_plugh", known), "");
}

TEST(ErrorText, RunsFromTheOutsideIn) {
    const Error e = Error{ErrorCode::invalid_input, "bad", {}}.in("contact 3").in("pass 1");
    EXPECT_EQ(e.text(), "pass 1: contact 3: bad");
}

}  // namespace
