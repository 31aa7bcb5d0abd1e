// Placing cutters and joining passes.
#include <gtest/gtest.h>

#include "support/tools.hpp"
#include "trunnion/pose/place.hpp"

namespace trunnion {
namespace {

/// Two passes on a cylinder about z of radius 20, tools leaning out.
PosePath two_passes() {
    PosePath p;
    for (int k = 0; k < 2; ++k) {
        for (int i = 0; i < 5; ++i) {
            const double a = 0.4 * k + 0.1;
            p.axis.push_back(Vec3(std::cos(a), std::sin(a), 0.3).normalized());
            p.cl.push_back({20 * std::cos(a), 20 * std::sin(a), 4.0 * i});
            p.contact.push_back(5 * k + i);
        }
        p.passes.push_back({static_cast<std::size_t>(5 * k), 5, PassKind::cut, false});
    }
    return p;
}

void expect_covered(const PosePath& p) {
    std::size_t covered = 0;
    for (const Pass& pass : p.passes) {
        ASSERT_EQ(pass.first, covered);
        ASSERT_GT(pass.count, 0u);
        covered += pass.count;
    }
    ASSERT_EQ(covered, p.size());
    std::int64_t next = 0;
    for (const std::int64_t c : p.contact)
        if (c >= 0) {
            ASSERT_EQ(c, next++);
        }
    ASSERT_EQ(next, 10);
}

TEST(Links, KeepAllContactsInOrderAndRunOnOrBeyondTheClearanceSurface) {
    const PosePath cuts = two_passes();
    const std::vector<ClearanceSurface> surfaces{ClearancePlane{Vec3::UnitZ(), 60.0},
                                                 ClearanceCylinder{Vec3::Zero(), Vec3::UnitZ(), 45.0},
                                                 ClearanceSphere{Vec3::Zero(), 70.0}};
    for (const ClearanceSurface& surface : surfaces) {
        LinkOptions options;
        options.surface = surface;
        const auto path = link_passes(cuts, options);
        ASSERT_TRUE(path) << path.error().text();
        expect_covered(*path);
        EXPECT_EQ(path->passes.front().kind, PassKind::link);
        EXPECT_EQ(path->passes.back().kind, PassKind::link);
        // Where the axis turns on a link, the tip is out on the surface.
        for (std::size_t i = 1; i < path->size(); ++i) {
            if (path->contact[i] >= 0 || angle_between(path->axis[i - 1], path->axis[i]) < 1e-9) continue;
            EXPECT_LE(angle_between(path->axis[i - 1], path->axis[i]), options.step_angle * (1 + 1e-9));
            for (const Vec3& p : {path->cl[i - 1], path->cl[i]}) {
                if (const auto* plane = std::get_if<ClearancePlane>(&surface)) {
                    EXPECT_GE(p.z(), plane->height - 1e-9);
                }
                if (const auto* cylinder = std::get_if<ClearanceCylinder>(&surface)) {
                    EXPECT_GE(std::hypot(p.x(), p.y()), cylinder->radius - 1e-9);
                }
                if (const auto* sphere = std::get_if<ClearanceSphere>(&surface)) {
                    EXPECT_GE(p.norm(), sphere->radius - 1e-9);
                }
            }
        }
        // Into and out of a cut along its axis, by the lead.
        for (std::size_t i = 1; i < path->size(); ++i)
            if (path->contact[i] >= 0 && path->contact[i - 1] < 0) {
                EXPECT_NEAR((path->cl[i - 1] - path->cl[i] - options.lead * path->axis[i]).norm(), 0.0, 1e-9);
            }
    }
}

TEST(Links, StayLowWhereAsked) {
    LinkOptions options;
    options.surface = ClearanceSphere{Vec3::Zero(), 70.0};
    options.low = {5.0};
    const auto path = link_passes(two_passes(), options);
    ASSERT_TRUE(path);
    expect_covered(*path);
    bool between = false;
    for (std::size_t i = 0; i < path->size(); ++i) {
        if (path->contact[i] == 4) between = true;
        if (path->contact[i] == 5) between = false;
        if (between) {
            EXPECT_LT(path->cl[i].norm(), 40.0);
        }
    }
    const PosePath alone = low_link(two_passes(), options, 0, 5.0);
    EXPECT_EQ(alone.contact.front(), 4);
    EXPECT_EQ(alone.contact.back(), 5);
}

TEST(Links, NameThePassThatNeverReachesTheSurface) {
    PosePath cuts = two_passes();
    for (std::size_t i = 5; i < 10; ++i) cuts.axis[i] = -Vec3::UnitZ();
    LinkOptions options;
    options.surface = ClearancePlane{Vec3::UnitZ(), 60.0};
    const auto path = link_passes(cuts, options);
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ErrorCode::no_solution);
    EXPECT_NE(path.error().message.find("pass 1"), std::string::npos);
}

TEST(PlaceCutter, PutsTheContactOnTheToolAndNamesWhatCannotBe) {
    ContactPath contacts;
    for (int i = 0; i < 3; ++i) {
        contacts.cc.push_back({2.0 * i, 0, 0});
        contacts.n.push_back(Vec3::UnitZ());
        contacts.f.push_back(Vec3::UnitX());
        contacts.uv.push_back(Vec2::Zero());
        contacts.face.push_back(0);
        contacts.given.push_back(0);
    }
    contacts.passes.push_back({0, 3, false});
    const Cutter ball = make_cutter(ball_spec(8.0));
    std::vector<Vec3> axes(3, Vec3(std::sin(0.3), 0, std::cos(0.3)));
    const auto path = place_cutter(contacts, axes, ball);
    ASSERT_TRUE(path);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR((path->cl[i] + 4.0 * axes[i] - contacts.cc[i] - 4.0 * Vec3::UnitZ()).norm(), 0.0, 1e-12);
    axes[1] = -Vec3::UnitZ();
    const auto upside_down = place_cutter(contacts, axes, ball);
    ASSERT_FALSE(upside_down);
    EXPECT_NE(upside_down.error().text().find("contact 1"), std::string::npos) << upside_down.error().text();
    axes.pop_back();
    EXPECT_EQ(place_cutter(contacts, axes, ball).error().code, ErrorCode::invalid_input);
}

}  // namespace
}  // namespace trunnion
