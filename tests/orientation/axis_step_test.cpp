// Steps behind a method: smoothing, limits, ranges, repair.
#include <gtest/gtest.h>

#include "support/aimed_random.hpp"
#include "support/test_parts.hpp"
#include "support/tools.hpp"
#include "trunnion/orientation/axis_step.hpp"
#include "trunnion/orientation/smooth.hpp"

namespace trunnion {
namespace {

class AxisSteps : public ::testing::Test {
protected:
    /// A straight pass on a plane, contacts at these places.
    static ContactPath line(const std::vector<double>& x) {
        ContactPath path;
        std::vector<Vec3> cc;
        for (const double t : x) cc.emplace_back(t, 0, 0);
        append_pass(path, cc, std::vector<Vec3>(x.size(), Vec3::UnitZ()), std::vector<Vec2>(x.size(), Vec2::Zero()),
                    std::vector<std::int32_t>(x.size(), 0), false);
        return path;
    }
    static Vec3 leaning(double lead, double tilt = 0.0) { return axis_from(LeadTilt{lead, tilt}, Vec3::UnitX(), Vec3::UnitZ()); }
    ToolAxes run(const AxisStep& step, const ContactPath& path, const ToolAxes& axes) {
        auto result = apply_step(step, path, axes, scene, {});
        if (!result) throw std::logic_error(result.error().text());
        return std::move(*result);
    }
    Part part = surface_part(saddle(), 1.0);
    Cutter cutter = make_cutter(ball_spec(6.0));
    Scene scene{part, cutter};
};

TEST_F(AxisSteps, SmoothingHalvesTheWaveOfItsLengthAndKeepsStraightRuns) {
    // A wave of small amplitude far from the ends: gain 1 / (1 + (length / wave)^4), the filter's own formula.
    for (const double wave : {5.0, 10.0, 20.0, 40.0}) {
        std::vector<double> x;
        ToolAxes axes;
        for (int i = 0; i <= 4000; ++i) {
            x.push_back(0.1 * i);
            axes.push_back(leaning(0.01 * std::sin(2 * kPi * x.back() / wave)));
        }
        const ContactPath path = line(x);
        const ToolAxes smooth = run(SmoothAxes{10.0, false}, path, axes);
        double most = 0;
        for (std::size_t i = 1500; i < 2500; ++i) most = std::max(most, std::abs(std::asin(smooth[i].x())));
        EXPECT_NEAR(most / 0.01, 1 / (1 + std::pow(10.0 / wave, 4)), 0.01) << wave;
    }
    // Uneven stations, axis turning evenly: chords of an even turn bend by the cube of the angle only.
    AimedRandom random(4);
    std::vector<double> x{0};
    for (int i = 0; i < 400; ++i) x.push_back(x.back() + random.uniform(0.01, 0.5));
    ToolAxes even;
    for (const double t : x) even.push_back(leaning(1e-3 * t));
    const ToolAxes same = run(SmoothAxes{30.0, false}, line(x), even);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_LT(angle_between(same[i], even[i]), 2e-5);
}

TEST_F(AxisSteps, SmoothingStopsWhereTheToolWouldNotBeClear) {
    std::vector<double> x;
    ToolAxes axes;
    for (int i = 0; i <= 200; ++i) {
        x.push_back(0.5 * i);
        axes.push_back(leaning(x.back() > 40 && x.back() < 60 ? 0.3 : 0.0));
    }
    const ContactPath path = line(x);
    // Only lean enough is clear from 42 to 58: plain smoothing breaks it.
    const auto clear = [&](std::size_t i, const Vec3& T) { return x[i] > 42 && x[i] < 58 ? std::asin(T.x()) - 0.29 : 1.0; };
    ToolAxes free = run(SmoothAxes{20.0, true}, path, axes);
    std::size_t broken = 0;
    for (std::size_t i = 0; i < free.size(); ++i) broken += clear(i, free[i]) < 0;
    ASSERT_GT(broken, 5u);
    scene.clearance = clear;
    const ToolAxes kept = run(SmoothAxes{20.0, true}, path, axes);
    double greatest = 0;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_GE(clear(i, kept[i]), 0.0) << i;
        if (i > 0) greatest = std::max(greatest, angle_between(kept[i - 1], kept[i]));
    }
    EXPECT_LT(greatest, 0.2) << "still smoother than the jump of 0.3 it started with";
}

TEST_F(AxisSteps, LimitHoldsExactlyAndSpreadsEvenly) {
    AimedRandom random(5);
    for (int k = 0; k < 30; ++k) {
        std::vector<double> x{0};
        ToolAxes axes{random.leaning(Vec3::UnitZ(), 0.6)};
        for (int i = 0; i < 120; ++i) {
            x.push_back(x.back() + random.uniform(0.1, 2.0));
            axes.push_back(random.integer(0, 9) == 0 ? random.leaning(Vec3::UnitZ(), 0.6) : axes.back());
        }
        const ContactPath path = line(x);
        const LimitAxisStep limit{0.05, 0.04};
        const ToolAxes slow = run(limit, path, axes);
        for (std::size_t i = 1; i < slow.size(); ++i)
            ASSERT_LE(angle_between(slow[i - 1], slow[i]),
                      std::min(limit.angle, limit.per_mm * (x[i] - x[i - 1])) * (1 + 1e-9) + 1e-12);
    }
    // One jump: the same distance from both ends of it.
    std::vector<double> x;
    ToolAxes jump;
    for (int i = 0; i <= 100; ++i) {
        x.push_back(i);
        jump.push_back(leaning(i <= 50 ? 0.0 : 0.5));
    }
    const ToolAxes slow = run(LimitAxisStep{0.02, 0.0}, line(x), jump);
    // The middle of the jump (between 50 and 51) stays the middle of the ramp.
    for (std::size_t i = 0; i <= 50; ++i)
        EXPECT_NEAR(angle_between(slow[50 - i], leaning(0.0)), angle_between(slow[51 + i > 100 ? 100 : 51 + i], leaning(0.5)),
                    1e-9);
    EXPECT_NEAR(std::asin(slow[50].x()) + std::asin(slow[51].x()), 0.5, 1e-9);
    // Motion within the limits is left alone.
    ToolAxes gentle;
    for (int i = 0; i <= 100; ++i) gentle.push_back(leaning(0.01 * i));
    const ToolAxes same = run(LimitAxisStep{0.0101, 0.0}, line(x), gentle);
    for (std::size_t i = 0; i <= 100; ++i) EXPECT_LT(angle_between(same[i], gentle[i]), 1e-12);
}

TEST_F(AxisSteps, ClampStaysInsideAndBendsSmoothly) {
    std::vector<double> x;
    ToolAxes axes;
    for (int i = 0; i <= 2000; ++i) {
        x.push_back(0.1 * i);
        axes.push_back(leaning(-1.0 + 0.001 * i, 0.3));
    }
    const ClampAxes clamp{{-0.2, 0.3}, {0.0, 0.1}, 0.05};
    const ToolAxes held = run(clamp, line(x), axes);
    double before = 0, step = 0;
    for (std::size_t i = 0; i < held.size(); ++i) {
        const LeadTilt a = lead_tilt_of(held[i], Vec3::UnitX(), Vec3::UnitZ()),
                       was = lead_tilt_of(axes[i], Vec3::UnitX(), Vec3::UnitZ());
        ASSERT_TRUE(a.lead >= clamp.lead.lo - 1e-12 && a.lead <= clamp.lead.hi + 1e-12);
        ASSERT_TRUE(a.tilt >= -1e-12 && a.tilt <= 0.1 + 1e-12);
        if (was.lead > -0.15 && was.lead < 0.25) {
            ASSERT_NEAR(a.lead, was.lead, 1e-12);
        }
        // No kink: the change of the change stays far below that of a hard stop (0.001).
        if (i > 1) {
            ASSERT_LT(std::abs(a.lead - before - step), 4e-5);
        }
        if (i > 0) step = a.lead - before;
        before = a.lead;
    }
    const ToolAxes hard = run(ClampAxes{{-0.2, 0.3}, {0.0, 0.1}, 0.0}, line(x), axes);
    EXPECT_NEAR(lead_tilt_of(hard.back(), Vec3::UnitX(), Vec3::UnitZ()).lead, 0.3, 1e-12);
}

TEST_F(AxisSteps, RepairFindsTheNearestClearAxisAndTurnsNeighboursAlong) {
    std::vector<double> x;
    ToolAxes axes;
    for (int i = 0; i <= 100; ++i) {
        x.push_back(0.5 * i);
        axes.push_back(leaning(0.0));
    }
    const ContactPath path = line(x);
    // From 20 to 30 mm the tool must lean by 0.21 rad or more to one side; at 40 mm nothing helps.
    scene.clearance = [&](std::size_t i, const Vec3& T) {
        if (x[i] == 40.0) return -1.0;
        return x[i] >= 20 && x[i] <= 30 ? T.y() - std::sin(0.21) : 1.0;
    };
    std::string note;
    scene.note = [&](std::string text) { note = std::move(text); };
    const ToolAxes mended = run(RepairAxes{0.5, 0.03, 4.0}, path, axes);
    double greatest = 0;
    for (std::size_t i = 0; i < mended.size(); ++i) {
        if (x[i] == 40.0) {
            EXPECT_EQ(mended[i], axes[i]);
            continue;
        }
        EXPECT_GE(scene.clearance(i, mended[i]), 0.0);
        EXPECT_LE(angle_between(mended[i], axes[i]), 0.21 + 0.03 + 1e-9) << "the first ring that reaches";
        if (i > 0) greatest = std::max(greatest, angle_between(mended[i - 1], mended[i]));
    }
    EXPECT_LT(greatest, 0.04) << "a ramp, not a jump";
    EXPECT_NE(note.find("contact 80"), std::string::npos) << note;
    EXPECT_NE(note.find("21 of 22"), std::string::npos) << note;
    scene.clearance = {};
    EXPECT_EQ(apply_step(RepairAxes{}, path, axes, scene, {}).error().code, ErrorCode::unsupported);
}

TEST_F(AxisSteps, SayWhatIsWrong) {
    const ContactPath path = line({0, 1, 2});
    const ToolAxes axes(3, Vec3::UnitZ());
    for (const AxisStep& bad : std::vector<AxisStep>{SmoothAxes{0.0, true}, LimitAxisStep{}, ClampAxes{{0.2, 0.1}, {0, 0}, 0},
                                                     RepairAxes{0.1, 0.2, 0}}) {
        scene.clearance = [](std::size_t, const Vec3&) { return 1.0; };
        const auto result = apply_step(bad, path, axes, scene, {});
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().code, ErrorCode::invalid_input);
        EXPECT_FALSE(result.error().context.empty());
    }
    std::atomic<bool> cancel{true};
    Control control;
    control.cancel = &cancel;
    EXPECT_EQ(apply_step(SmoothAxes{}, path, axes, scene, control).error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace trunnion
