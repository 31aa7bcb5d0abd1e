// Two-point positioning against closed forms, brute force over the surface with the cutter's own profile, and the numbers printed
// in the sheet.
#include <algorithm>

#include <gtest/gtest.h>

#include "support/aimed_random.hpp"
#include "support/vcrf_surfaces.hpp"
#include "trunnion/pose/multipoint.hpp"

namespace trunnion {
namespace {

MultipointSolver solver_of(const Surface& surface, const Cutter& cutter, MultipointOptions options = {}) {
    auto solver = MultipointSolver::build(surface, cutter, options);
    if (!solver) throw std::logic_error(solver.error().text());
    return *solver;
}

MultipointPose pose_at(const MultipointSolver& solver, double x, double y, const Vec3& feed = Vec3::UnitY()) {
    auto pose = solver.drop(x, y, feed);
    if (!pose) throw std::logic_error(pose.error().text());
    return *pose;
}

double depth_at(const Cutter& cutter, const Vec3& cl, const Vec3& T, const Vec3& S) {
    const Vec3 p = S - cl;
    const double h = p.dot(T);
    return -cutter.pieces().front().profile.distance((p - h * T).norm(), h).distance;
}

/// Deepest point of the surface in the cutting part: dense samples, then the best of them refined by shrinking grids. Shares
/// nothing with the solver but the surface.
double brute_gouge(const Surface& surface, const Cutter& cutter, const Vec3& cl, const Vec3& T, int n = 160) {
    const Domain& d = surface.domain();
    struct Sample {
        double depth, u, v;
    };
    std::vector<Sample> best;
    std::vector<double> u, v;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) u.push_back(d.u.at(double(i) / n)), v.push_back(d.v.at(double(j) / n));
    SurfaceBatch batch;
    surface.evaluate(u, v, 0, batch);
    for (std::size_t k = 0; k < u.size(); ++k) best.push_back({depth_at(cutter, cl, T, batch.point(k)), u[k], v[k]});
    std::partial_sort(best.begin(), best.begin() + 12, best.end(),
                      [](const Sample& a, const Sample& b) { return a.depth > b.depth; });
    double deepest = -1e9;
    for (int k = 0; k < 12; ++k) {
        Sample s = best[static_cast<std::size_t>(k)];
        for (double h = 1.0 / n; h > 1e-9; h *= 0.5)
            for (int a = -2; a <= 2; ++a)
                for (int b = -2; b <= 2; ++b) {
                    const double pu = std::clamp(s.u + a * 0.5 * h * d.u.length(), d.u.lo, d.u.hi),
                                 pv = std::clamp(s.v + b * 0.5 * h * d.v.length(), d.v.lo, d.v.hi);
                    const double depth = depth_at(cutter, cl, T, surface.point(pu, pv));
                    if (depth > s.depth) s = {depth, pu, pv};
                }
        deepest = std::max(deepest, s.depth);
    }
    return deepest;
}

Surface inclined_plane(double slope, double turn) {
    const Vec3 x(std::cos(turn) * std::cos(slope), std::sin(turn) * std::cos(slope), std::sin(slope)),
        y(-std::sin(turn), std::cos(turn), 0.0);
    return *Surface::bezier({{-200.0 * x - 200.0 * y, -200.0 * x + 200.0 * y}, {200.0 * x - 200.0 * y, 200.0 * x + 200.0 * y}});
}

TEST(Multipoint, OnAnInclinedPlaneTheTiltIsTheSlope) {
    AimedRandom random(41);
    for (int k = 0; k < 60; ++k) {
        const bool open = random.coin();
        const double slope = k < 6 ? std::pow(10.0, -k) : random.uniform(0.01, 0.9), turn = random.uniform(0.0, 6.28);
        const MultipointSolver solver = solver_of(inclined_plane(slope, turn), vcrf_cutter(open));
        const double x = random.uniform(-20, 20), y = random.uniform(-20, 20);
        const MultipointPose p = pose_at(solver, x, y);
        EXPECT_NEAR(p.tilt, slope, 5e-9) << "seed " << random.seed() << " case " << k << " open " << open;  // largest seen 1e-9
        const Vec3 n(-std::sin(slope) * std::cos(turn), -std::sin(slope) * std::sin(turn), std::cos(slope));
        EXPECT_LT(angle_between(p.T, n), 5e-9);
        EXPECT_LT(angle_between(p.normal, n), 1e-9);
        // d0 = 0: height from the facet formula of section 10, written out: the contact lies uphill.
        const double along = x * std::cos(turn) + y * std::sin(turn);
        EXPECT_NEAR(p.z_c, (6.0 + std::sin(slope) * (along + 6.7)) / std::cos(slope), 1e-10);
    }
}

TEST(Multipoint, InABowlTheAxisPassesThroughTheCentre) {
    AimedRandom random(42);
    for (int k = 0; k < 20; ++k) {
        const double Rs = random.uniform(40.0, 200.0), x0 = random.uniform(0.5, 0.3 * Rs), turn = random.uniform(0.0, 6.28);
        AnalyticData ball{AnalyticKind::sphere, Rs, 1.0, 0.0, true};
        const Surface bowl = *Surface::analytic(ball)->restricted({0.0, 2.0 * kPi}, {1.9, kPi});
        for (const bool open : {false, true}) {
            const MultipointSolver solver = solver_of(bowl, vcrf_cutter(open));
            const MultipointPose p = pose_at(solver, x0 * std::cos(turn), x0 * std::sin(turn));
            const double psi = std::asin((x0 + 6.7) / (Rs - 6.0)), beta = psi - std::asin(6.7 / (Rs - 6.0));
            EXPECT_NEAR(p.tilt, beta, 1e-7) << "seed " << random.seed() << " case " << k << " open " << open;
            EXPECT_NEAR(p.z_c, -std::sqrt((Rs - 6.0) * (Rs - 6.0) - (x0 + 6.7) * (x0 + 6.7)), 1e-9);
            const Vec3 C = p.CL + 6.0 * p.T;
            EXPECT_LT((C - C.dot(p.T) * p.T).norm(), 1e-5) << "the axis misses the centre of the sphere";
        }
    }
}

TEST(Multipoint, OnADomeTheOpenToolStandsAroundIt) {
    AimedRandom random(43);
    for (int k = 0; k < 15; ++k) {
        const double Rs = random.uniform(60.0, 300.0), x0 = random.uniform(7.0, 0.3 * Rs), turn = random.uniform(0.0, 6.28);
        const Surface dome =
            *Surface::analytic({AnalyticKind::sphere, Rs, 1.0, 0.0, false})->restricted({0.0, 2.0 * kPi}, {0.0, 1.2});
        const MultipointSolver solver = solver_of(dome, vcrf_cutter(true));
        const MultipointPose p = pose_at(solver, x0 * std::cos(turn), x0 * std::sin(turn));
        const double psi = std::asin((x0 - 6.7) / (Rs + 6.0)), beta = psi + std::asin(6.7 / (Rs + 6.0));
        EXPECT_NEAR(p.tilt, beta, 1e-7) << "seed " << random.seed() << " case " << k;
        // Closed, the same dome is touched with T = n.
        const MultipointPose q = pose_at(solver_of(dome, vcrf_cutter(false)), x0 * std::cos(turn), x0 * std::sin(turn));
        EXPECT_EQ(q.status, MultipointStatus::merged_contacts);
        EXPECT_LT(angle_between(q.T, q.normal), 1e-9);
    }
}

/// Height is second order at a contact, so that a brute force that comes within 1e-5 mm of it sees the gouge to 1e-11 mm.
TEST(Multipoint, PosesAreClearAndATenthOfADegreeMoreIsNot) {
    AimedRandom random(44);
    double deepest = 0.0;
    for (int k = 0; k < 90; ++k) {
        const auto which = static_cast<VcrfSurface>(k % 3);
        const bool open = (k / 3) % 2 == 0;
        const Surface surface = vcrf_surface(which);
        const Cutter cutter = vcrf_cutter(open);
        const MultipointSolver solver = solver_of(surface, cutter);
        MultipointPose p = pose_at(solver, random.uniform(8, 142), random.uniform(8, 142));
        const double gouge = brute_gouge(surface, cutter, p.CL, p.T);
        deepest = std::max(deepest, gouge);
        EXPECT_LT(gouge, 1e-6) << "seed " << random.seed() << " case " << k;
        EXPECT_NEAR(depth_at(cutter, p.CL, p.T, p.P), 0.0, 1e-9);
        EXPECT_LE(p.certified_gouge, 1e-3);
        if (p.status != MultipointStatus::two_contacts) continue;
        EXPECT_NEAR(depth_at(cutter, p.CL, p.T, p.Q), 0.0, 1e-9);
        const double end = p.tilt;
        for (const double part : {0.2, 0.5, 0.9}) {
            p.turn_to(part * end, 6.7, 6.0);
            EXPECT_LT(brute_gouge(surface, cutter, p.CL, p.T, 80), 1e-6)
                << "seed " << random.seed() << " case " << k << " part " << part;
        }
        if (p.separation() < 2.0) continue;  // near-merged contacts gouge by next to nothing
        p.turn_to(end + radians(0.1), 6.7, 6.0);
        EXPECT_GT(depth_at(cutter, p.CL, p.T, p.Q), 1e-6);
    }
    RecordProperty("deepest", std::to_string(deepest));
}

struct Ranges {
    double tilt_lo, tilt_hi, tilt_lo_138, tilt_hi_138, sep_lo, sep_mid, sep_hi, inclination_lo, inclination_hi, feed_mid;
};
double median(std::vector<double> x) {
    std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
    return x[x.size() / 2];
}

/// The table of section 11, open bottom, to its printed digits.
TEST(Multipoint, GivesTheSheetsRangesOverThePapersExperiment) {
    const Ranges printed[3] = {{0.65, 16.76, 0.65, 11.10, 6.4, 12.0, 13.2, 1.01, 1.38, 44},
                               {0.00, 14.39, 0.68, 10.90, 0.0, 7.2, 13.5, 1.38, 1.56, 46},
                               {0.03, 17.05, 2.38, 12.32, 0.25, 4.8, 13.5, 0.00, 0.91, 34}};
    for (int s = 0; s < 3; ++s) {
        const MultipointSolver solver = solver_of(vcrf_surface(static_cast<VcrfSurface>(s)), vcrf_cutter(true));
        const Ranges& want = printed[s];
        std::vector<double> tilt, tilt_138, separation, inclination, feed;
        int edges = 0, corners = 0;
        for (const Vec2& f : vcrf_footprints()) {
            const MultipointPose p = pose_at(solver, f.x(), f.y());
            tilt.push_back(degrees(p.tilt));
            edges += p.P_kind == MultipointContact::edge;
            corners += p.P_kind == MultipointContact::corner;
        }
        for (const Vec2& f : vcrf_comparison()) {
            const MultipointPose p = pose_at(solver, f.x(), f.y());
            tilt_138.push_back(degrees(p.tilt));
            separation.push_back(p.separation());
            inclination.push_back(degrees(angle_between(p.T, p.normal)));
            const Vec3 d = p.Q - p.P;
            feed.push_back(degrees(std::atan2(std::abs(d.x()), std::abs(d.y()))));
        }
        const auto [lo, hi] = std::minmax_element(tilt.begin(), tilt.end());
        const auto [lo1, hi1] = std::minmax_element(tilt_138.begin(), tilt_138.end());
        const auto [lo2, hi2] = std::minmax_element(separation.begin(), separation.end());
        const auto [lo3, hi3] = std::minmax_element(inclination.begin(), inclination.end());
        EXPECT_NEAR(*lo, want.tilt_lo, 0.0051) << s;
        EXPECT_NEAR(*hi, want.tilt_hi, 0.0051) << s;
        EXPECT_NEAR(*lo1, want.tilt_lo_138, 0.0051) << s;
        EXPECT_NEAR(*hi1, want.tilt_hi_138, 0.0051) << s;
        EXPECT_NEAR(*lo2, want.sep_lo, 0.051) << s;
        EXPECT_NEAR(median(separation), want.sep_mid, 0.1) << s;
        EXPECT_NEAR(*hi2, want.sep_hi, 0.051) << s;
        EXPECT_NEAR(*lo3, want.inclination_lo, 0.0051) << s;
        EXPECT_NEAR(*hi3, want.inclination_hi, 0.0051) << s;
        EXPECT_NEAR(median(feed), want.feed_mid, 1.0) << s;
        if (s == 1) {
            EXPECT_EQ(edges, 274);
            EXPECT_EQ(corners, 14);
        }
    }
}

TEST(Multipoint, MirroredTurnedAndTransposedSurfacesGiveTheSamePosesMoved) {
    AimedRandom random(45);
    const Vec3 centre(75.0, 75.0, 0.0);
    for (int k = 0; k < 40; ++k) {
        const bool open = random.coin();
        const Cutter cutter = vcrf_cutter(open);
        const double x = random.uniform(2, 148), y = random.uniform(2, 148);
        const auto which = random.coin() ? VcrfSurface::convex : VcrfSurface::concave;
        const MultipointSolver solver = solver_of(vcrf_surface(which), cutter);
        const MultipointPose p = pose_at(solver, x, y), mirrored = pose_at(solver, 150.0 - x, y),
                             turned = pose_at(solver, 150.0 - y, x);
        EXPECT_NEAR(p.tilt, mirrored.tilt, 1e-9) << "seed " << random.seed() << " case " << k;
        EXPECT_NEAR(p.tilt, turned.tilt, 1e-9);
        EXPECT_NEAR(p.z_c, mirrored.z_c, 1e-9);
        EXPECT_LT((mirrored.CL - Vec3(150.0 - p.CL.x(), p.CL.y(), p.CL.z())).norm(), 1e-6);
        EXPECT_LT((turned.CL - Vec3(150.0 - p.CL.y(), p.CL.x(), p.CL.z())).norm(), 1e-6);
        const MultipointPose a = pose_at(solver_of(vcrf_surface(VcrfSurface::saddle), cutter), x, y),
                             b = pose_at(solver_of(vcrf_surface(VcrfSurface::saddle, true), cutter), y, x);
        EXPECT_NEAR(a.tilt, b.tilt, 1e-8);
        EXPECT_LT((a.CL - Vec3(b.CL.y(), b.CL.x(), b.CL.z())).norm(), 1e-6);
    }
}

TEST(Multipoint, RigidMotionsMoveThePoseAndNothingElse) {
    AimedRandom random(46);
    for (int k = 0; k < 25; ++k) {
        const auto which = static_cast<VcrfSurface>(k % 3);
        const Cutter cutter = vcrf_cutter(k % 2 == 0);
        const Vec3 T0 = random.direction(), shift = random.vector(300.0);
        Mat3 R;  // takes z to T0 and x to the drop frame's first axis
        R.col(2) = T0;
        R.col(0) = any_perpendicular(T0);
        R.col(1) = T0.cross(R.col(0));
        auto rows = vcrf_control(which);
        for (auto& row : rows)
            for (Vec3& p : row) p = R * p + shift;
        MultipointOptions options;
        options.drop_axis = T0;
        const double x = random.uniform(5, 145), y = random.uniform(5, 145);
        const MultipointPose a = pose_at(solver_of(vcrf_surface(which), cutter), x, y);
        const MultipointPose b =
            pose_at(solver_of(*Surface::bezier(rows), cutter, options), x + shift.dot(R.col(0)), y + shift.dot(R.col(1)));
        EXPECT_NEAR(a.tilt, b.tilt, 2e-8) << "seed " << random.seed() << " case " << k;
        EXPECT_LT((R * a.CL + shift - b.CL).norm(), 1e-6);
        EXPECT_LT((R * a.T - b.T).norm(), 1e-6);
    }
}

/// The middle knot put in by de Casteljau's halves: the same surface in four patches, then as a rational one through other code.
TEST(Multipoint, RefiningTheSurfaceChangesNothing) {
    AimedRandom random(47);
    for (int k = 0; k < 30; ++k) {
        const auto which = static_cast<VcrfSurface>(k % 3);
        const Cutter cutter = vcrf_cutter(k % 2 == 0);
        const auto rows = vcrf_control(which);
        const auto halves = [](const std::array<Vec3, 4>& p) {
            const Vec3 a = 0.5 * (p[0] + p[1]), m = 0.5 * (p[1] + p[2]), c = 0.5 * (p[2] + p[3]);
            return std::vector<Vec3>{p[0], a, 0.5 * (a + m), 0.5 * (m + c), c, p[3]};  // C2: the middle point falls out
        };
        std::vector<std::vector<Vec3>> wide;
        for (const auto& row : rows) wide.push_back(halves({row[0], row[1], row[2], row[3]}));
        BSplineData data;
        data.knots_u = {0, 0, 0, 0, 1, 1, 1, 1};
        data.knots_v = {0, 0, 0, 0, 0.5, 0.5, 1, 1, 1, 1};
        data.count_u = 4;
        data.count_v = 6;
        for (const auto& row : wide) data.control.insert(data.control.end(), row.begin(), row.end());
        const double x = random.uniform(5, 145), y = random.uniform(5, 145);
        const MultipointPose a = pose_at(solver_of(vcrf_surface(which), cutter), x, y),
                             b = pose_at(solver_of(*Surface::bspline(data), cutter), x, y);
        EXPECT_NEAR(a.z_c, b.z_c, 1e-10) << "seed " << random.seed() << " case " << k;
        EXPECT_NEAR(a.tilt, b.tilt, 1e-8);
        EXPECT_LT((a.CL - b.CL).norm(), 1e-6);
        // Degree raised with weights that cancel: (S w) / w with w = 1 + u is no bicubic for the solver, but the same surface.
        BSplineData rational;
        rational.degree_u = 4;
        rational.degree_v = 3;
        rational.knots_u = {0, 0, 0, 0, 0, 1, 1, 1, 1, 1};
        rational.knots_v = {0, 0, 0, 0, 1, 1, 1, 1};
        rational.count_u = 5;
        rational.count_v = 4;
        for (int i = 0; i <= 4; ++i)
            for (int j = 0; j < 4; ++j) {
                // (1 + u) has Bezier weights 1, 2; the product of degree 4: i/4 * 2 * c[i-1] + (1 - i/4) * c[i].
                const double lo = i / 4.0 * 2.0, hi = 1.0 - i / 4.0;
                Vec3 sum = Vec3::Zero();
                if (i > 0) sum += lo * rows[static_cast<std::size_t>(i - 1)][static_cast<std::size_t>(j)];
                if (i < 4) sum += hi * rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
                rational.control.push_back(sum / (lo + hi));
                rational.weights.push_back(lo + hi);
            }
        const MultipointPose c = pose_at(solver_of(*Surface::bspline(rational), cutter), x, y);
        EXPECT_NEAR(a.z_c, c.z_c, 1e-9);
        EXPECT_NEAR(a.tilt, c.tilt, 1e-6) << "seed " << random.seed() << " case " << k << " separation " << a.separation();
    }
}

TEST(Multipoint, AStraightValleyHoldsTheToolUpright) {
    // z = k x^2 / 2 along y: beta = 0 and Q mirrors P, where x1 = Ro + Ri sin(atan(k x1)).
    const double k = 0.02;
    const auto z = [&](double x) { return 0.5 * k * x * x; };
    std::vector<std::vector<Vec3>> rows{{Vec3(-60, -60, z(60)), Vec3(-60, 60, z(60))},
                                        {Vec3(0, -60, -z(60)), Vec3(0, 60, -z(60))},
                                        {Vec3(60, -60, z(60)), Vec3(60, 60, z(60))}};
    for (const bool open : {false, true}) {
        const MultipointPose p = pose_at(solver_of(*Surface::bezier(rows), vcrf_cutter(open)), 0.0, 3.0);
        double x1 = 6.7;
        for (int i = 0; i < 200; ++i) x1 = 6.7 + 6.0 * std::sin(std::atan(k * x1));
        EXPECT_NEAR(p.tilt, 0.0, 1e-9);
        EXPECT_TRUE(p.ambiguous);
        EXPECT_NEAR(std::abs(p.P.x()), x1, 1e-7);
        EXPECT_LT((Vec3(-p.P.x(), p.P.y(), p.P.z()) - p.Q).norm(), 1e-6);
    }
}

TEST(Multipoint, RefusesWhatItCannotPlace) {
    const MultipointSolver solver = solver_of(vcrf_surface(VcrfSurface::saddle), vcrf_cutter(false));
    const auto away = solver.drop(400.0, 20.0);
    ASSERT_FALSE(away.has_value());
    EXPECT_NE(away.error().text().find("NoSurfaceUnderTool at footprint (400, 20)"), std::string::npos) << away.error().text();
    EXPECT_TRUE(solver.drop(162.6, 75.0).has_value());  // the shadow overlaps by a tenth of a millimetre
    EXPECT_FALSE(solver.drop(162.71, 75.0).has_value());
    EXPECT_FALSE(solver.drop(std::nan(""), 0.0).has_value());
    CutterSpec flat;
    flat.shape = CutterShape::flat;
    flat.diameter = 10.0;
    EXPECT_FALSE(MultipointSolver::build(vcrf_surface(VcrfSurface::saddle), *Cutter::from(flat), {}).has_value());
}

TEST(Multipoint, ABallIsDroppedAndNotTilted) {
    CutterSpec spec;
    spec.shape = CutterShape::ball;
    spec.diameter = 12.0;
    const Cutter ball = *Cutter::from(spec);
    const Surface surface = vcrf_surface(VcrfSurface::saddle);
    const MultipointPose p = pose_at(solver_of(surface, ball), 60.0, 70.0);
    EXPECT_EQ(p.status, MultipointStatus::ball_has_no_tilt);
    EXPECT_EQ(p.T, Vec3(Vec3::UnitZ()));
    EXPECT_NEAR(brute_gouge(surface, ball, p.CL, p.T), 0.0, 1e-9);
}

}  // namespace
}  // namespace trunnion
