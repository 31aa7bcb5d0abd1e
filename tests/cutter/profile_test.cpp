// Profile distances, gradients and supports against a twin that shares no code.
#include <gtest/gtest.h>

#include "support/reference_profile.hpp"
#include "support/tools.hpp"

namespace trunnion {
namespace {

constexpr double kUlp = std::numeric_limits<double>::epsilon();

const Profile& profile_of(const Cutter& cutter, std::size_t piece = 0) {
    return cutter.pieces()[piece].profile;
}

TEST(Profile, DistanceEqualsTheLongDoubleTwinForEveryShapeAtEveryScale) {
    double worst = 0.0;
    for (const double scale : {1e-3, 1.0, 1e4}) {
        for (const auto& [name, spec] : one_of_every_shape(scale)) {
            const Cutter cutter = make_cutter(spec);
            const auto twin = ReferenceProfile<long double>::of(cutter.spec());
            const double size = profile_of(cutter).height_hi() + profile_of(cutter).radius_max() + cutter.spec().barrel_radius;
            AimedRandom random(11);
            for (int i = 0; i < 4000; ++i) {
                // Half of the points close to the boundary, where the feature that is nearest changes.
                double rho = random.uniform(0.0, 1.5) * profile_of(cutter).radius_max(),
                       z = random.uniform(-0.5, 1.5) * profile_of(cutter).height_hi();
                if (i % 2 == 1) {
                    const auto points = twin.sampled(40);
                    const auto& p = points[static_cast<std::size_t>(random.integer(0, static_cast<int>(points.size()) - 1))];
                    const double away = random.log_uniform(1e-14, 0.1) * size, turn = random.uniform(0.0, 2.0 * kPi);
                    rho = std::abs(static_cast<double>(p.first) + away * std::cos(turn));
                    z = static_cast<double>(p.second) + away * std::sin(turn);
                }
                const double ours = profile_of(cutter).distance(rho, z).distance;
                const double theirs = static_cast<double>(twin.distance(rho, z));
                worst = std::max(worst, std::abs(ours - theirs) / (kUlp * size));
                ASSERT_NEAR(ours, theirs, 64 * kUlp * size) << name << " scale " << scale << " at (" << rho << ", " << z << ")";
            }
        }
    }
    RecordProperty("worst_in_ulp_of_size", std::to_string(worst));
}

TEST(Profile, DistanceIsExactOnTheLinesWhereOneFeatureTakesOverFromTheNext) {
    // On the line through the centre of an arc and its end, rounding may put a point in neither of the two sectors.
    for (const double scale : {1e-3, 0.0729, 1.0, 1e4}) {
        for (const auto& [name, spec] : one_of_every_shape(scale)) {
            const Cutter cutter = make_cutter(spec);
            const auto twin = ReferenceProfile<long double>::of(cutter.spec());
            const double size = cutter.length() + cutter.spec().barrel_radius;
            AimedRandom random(17);
            for (const ProfileSegment& s : profile_of(cutter).outer()) {
                for (const Vec2& end : {s.from, s.to}) {
                    for (int i = 0; i < 200; ++i) {
                        const Vec2 out = s.arc ? Vec2((end - s.centre).normalized())
                                               : Vec2((s.to - s.from).y(), -(s.to - s.from).x()).normalized();
                        const Vec2 p = end + random.uniform(-0.5, 0.5) * (i % 2 == 0 ? 1.0 : 1e-15) * size * out;
                        if (p.x() < 0.0) continue;
                        ASSERT_NEAR(profile_of(cutter).distance(p.x(), p.y()).distance,
                                    static_cast<double>(twin.distance(p.x(), p.y())), 128 * kUlp * size)
                            << name << " scale " << scale << " at (" << p.x() << ", " << p.y() << ")";
                    }
                }
            }
        }
    }
}

TEST(Profile, DistanceEqualsTheNearestPointOfADensePolyline) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const auto twin = ReferenceProfile<double>::of(cutter.spec());
        const auto points = twin.sampled(4000);
        AimedRandom random(12);
        const double size = 1.5 * profile_of(cutter).height_hi();
        for (int i = 0; i < 300; ++i) {
            const double rho = random.uniform(0.0, size), z = random.uniform(-0.3 * size, 1.3 * size);
            double least = std::numeric_limits<double>::infinity();
            for (const auto& [x, y] : points) least = std::min(least, std::hypot(rho - x, z - y));
            const double ours = profile_of(cutter).distance(rho, z).distance;
            // Neighbouring samples are at most size / 2000 apart.
            ASSERT_LE(std::abs(ours), least + 1e-12) << name;
            ASSERT_GE(std::abs(ours), least - size / 2000.0) << name;
            ASSERT_EQ(ours < 0.0, twin.inside(rho, z)) << name << " at (" << rho << ", " << z << ")";
        }
    }
}

TEST(Profile, ShankAndHolderConesHaveTheirTwinsDistance) {
    CutterSpec spec = bull_spec(10, 2);
    spec.flute = 20;
    spec.shank = {{10, 12, 30}};
    spec.holder = {{30, 40, 25}, {50, 45, 40}};
    const Cutter cutter = make_cutter(spec);
    ASSERT_EQ(cutter.pieces().size(), 4u);
    EXPECT_DOUBLE_EQ(cutter.length(), 20 + 30 + 25 + 40);
    const double bases[] = {20, 50, 75};
    const CutterSpec::Cone cones[] = {spec.shank[0], spec.holder[0], spec.holder[1]};
    AimedRandom random(13);
    for (std::size_t k = 0; k < 3; ++k) {
        const auto twin = ReferenceProfile<long double>::cone(bases[k], cones[k]);
        for (int i = 0; i < 3000; ++i) {
            const double rho = random.uniform(0, 60), z = random.uniform(-20, 140);
            ASSERT_NEAR(profile_of(cutter, k + 1).distance(rho, z).distance, static_cast<double>(twin.distance(rho, z)),
                        1e-13 * 140);
        }
    }
}

TEST(Profile, GradientIsUnitAndEqualsTheFiniteDifferenceAwayFromTheMedialAxis) {
    int compared = 0;
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const Profile& profile = profile_of(cutter);
        AimedRandom random(14);
        const double size = profile.height_hi();
        for (int i = 0; i < 1000; ++i) {
            const double rho = random.uniform(0.01, 1.2) * size, z = random.uniform(-0.2, 1.2) * size, h = 1e-6 * size;
            const ProfileDistance d = profile.distance(rho, z);
            ASSERT_NEAR(d.gradient.norm(), 1.0, 1e-12) << name;
            const Vec2 central((profile.distance(rho + h, z).distance - profile.distance(rho - h, z).distance) / (2 * h),
                               (profile.distance(rho, z + h).distance - profile.distance(rho, z - h).distance) / (2 * h));
            // On the medial axis (inside, equally far from two sides) there is no gradient: the central difference is short.
            if (std::abs(central.norm() - 1.0) > 1e-4) {
                EXPECT_LT(d.distance, 0.0) << name;
                continue;
            }
            ++compared;
            ASSERT_LT((central - d.gradient).norm(), 1e-4) << name << " at (" << rho << ", " << z << ")";
        }
    }
    EXPECT_GT(compared, 10'000);
}

TEST(Profile, EveryGradientSupportsTheConvexDistanceFromBelow) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const Profile& profile = profile_of(cutter);
        AimedRandom random(15);
        const double size = profile.height_hi();
        for (int i = 0; i < 4000; ++i) {
            const Vec2 p(random.uniform(0, size), random.uniform(-0.2, 1.2) * size),
                q(random.uniform(0, size), random.uniform(-0.2, 1.2) * size);
            const ProfileDistance at_p = profile.distance(p.x(), p.y());
            ASSERT_GE(profile.distance(q.x(), q.y()).distance, at_p.distance + at_p.gradient.dot(q - p) - 1e-12 * size) << name;
        }
    }
}

TEST(Profile, SupportIsTheFarthestSampledPoint) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const auto points = ReferenceProfile<double>::of(cutter.spec()).sampled(2000);
        AimedRandom random(16);
        for (int i = 0; i < 200; ++i) {
            const double angle = random.uniform(-kPi / 2, kPi / 2);
            const Vec2 d(std::cos(angle), std::sin(angle));
            double most = -std::numeric_limits<double>::infinity();
            for (const auto& [x, y] : points) most = std::max(most, d.x() * x + d.y() * y);
            const double ours = d.dot(profile_of(cutter).support(d));
            // Samples of an arc fall short of its crest by at most R (step / R)^2 / 8.
            EXPECT_GE(ours, most - 1e-9) << name;
            EXPECT_LE(ours, most + 1e-3) << name;
        }
    }
}

TEST(Profile, BoundingBallHoldsTheBodyAndTouchesIt) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const Profile& profile = profile_of(cutter);
        double far = 0.0;
        for (const auto& [x, y] : ReferenceProfile<double>::of(cutter.spec()).sampled(500))
            far = std::max(far, std::hypot(x, y - profile.bounding_centre()));
        EXPECT_LE(far, profile.bounding_radius() * (1 + 1e-14)) << name;
        EXPECT_GE(far, profile.bounding_radius() * (1 - 1e-4)) << name;
    }
}

TEST(Profile, PolylineFollowsTheArcsWithinTheChord) {
    for (const auto& [name, spec] : one_of_every_shape()) {
        const Cutter cutter = make_cutter(spec);
        const auto twin = ReferenceProfile<double>::of(cutter.spec());
        const std::vector<Vec2> line = profile_of(cutter).polyline(0.01);
        for (std::size_t i = 0; i + 1 < line.size(); ++i)
            for (const double t : {0.0, 0.5, 1.0}) {
                const Vec2 p = line[i] + t * (line[i + 1] - line[i]);
                EXPECT_LE(std::abs(twin.distance(p.x(), p.y())), 0.01 * (1 + 1e-6)) << name;
            }
    }
}

TEST(Profile, RefusesWhatIsNotAConvexOutline) {
    const auto line = [](Vec2 a, Vec2 b) { return ProfileSegment{a, b, false, Vec2::Zero(), 0.0}; };
    EXPECT_FALSE(Profile::from({}));
    EXPECT_FALSE(Profile::from({line({0, 0}, {0, 0})}));
    const auto gap = Profile::from({line({0, 0}, {5, 0}), line({6, 0}, {6, 10})});
    ASSERT_FALSE(gap);
    EXPECT_NE(gap.error().message.find("gap"), std::string::npos);
    const auto dent = Profile::from({line({0, 0}, {5, 0}), line({5, 0}, {2, 5}), line({2, 5}, {6, 10})});
    ASSERT_FALSE(dent);
    EXPECT_NE(dent.error().message.find("not convex"), std::string::npos);
    EXPECT_FALSE(Profile::from({line({0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0}), line({5, 0}, {5, 9})}));
    EXPECT_FALSE(Profile::from({line({-3, 0}, {5, 0}), line({5, 0}, {5, 9})}));
}

}  // namespace
}  // namespace trunnion
