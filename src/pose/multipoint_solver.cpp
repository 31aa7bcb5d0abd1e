#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "pose/multipoint_scan.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

using namespace detail;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSamePoint = 1e-6;       // mm: two runs of Newton ended at one place
constexpr double kSameHeight = 1e-10;     // mm: what symmetry leaves between equal maxima
constexpr double kSameTurn = 1e-9;        // rad: alike
constexpr double kMergedDistance = 1e-4;  // mm: closer second contacts are the first one, touched to second order
constexpr int kMostRepairs = 40;
constexpr std::size_t kMostSeeds = 8;

/// One local optimum.
struct Spot {
    std::uint32_t field = 0;
    double u = 0.0, v = 0.0, value = 0.0;
    Vec3 S = Vec3::Zero();
    Jet jet;
    MultipointContact kind = MultipointContact::interior;
    bool converged = true;
};

struct Scratch {
    std::vector<SpanBox> stack;
    std::vector<Spot> seeds;
};

/// The value is found, though on a ring of equal contacts the place may wander for ever.
bool settled(const Minimum& m) {
    constexpr double kLeft = 1e-9;  // mm or rad
    return m.converged || m.gain < kLeft;
}

Spot spot_of(const Seed& seed) {
    Spot spot;
    spot.field = seed.field;
    spot.u = seed.u;
    spot.v = seed.v;
    return spot;
}

/// mm: nearer to P the turn is taken as that at this distance. Its slope along the valley is some hundredths of a degree per mm,
/// so that 3e-5 costs 1e-8 rad. Where displacements are differences of points 100 mm from the origin, b ~ s^2 is known to 2 Ri
/// 1e-14 / s^2 of itself only: 1e-9 at 1e-2 mm, where the valley's bottom (slope 0) is still known to 1e-7 rad.
double centre_of(const Field& field) {
    return field.exact_near() ? 3e-5 : 1e-2;
}

Vec2 scale_of(const SurfacePoint& p) {
    // A degenerate side (pole) still needs a scale: any length will do where nothing moves.
    constexpr double kLeast = 1e-9;
    return {std::max(kLeast, p.Su.norm()), std::max(kLeast, p.Sv.norm())};
}

/// The first surface of contact candidates at equal value, without repetitions; best (least) value first.
void keep_distinct(std::vector<Spot>& spots) {
    std::sort(spots.begin(), spots.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    std::vector<Spot> kept;
    for (const Spot& s : spots)
        if (std::none_of(kept.begin(), kept.end(), [&](const Spot& k) { return (k.S - s.S).norm() < 10.0 * kSamePoint; }))
            kept.push_back(s);
    spots = std::move(kept);
}

/// Polar coordinates about a point of the parameter plane, in mm on the tangent plane there: (u, v) = centre + r M (cos, sin). A
/// cutter touches along a ring; what is a bent valley in u and v is a straight one here.
struct Polar {
    Vec2 centre = Vec2::Zero();
    Eigen::Matrix2d M = Eigen::Matrix2d::Identity();

    Vec2 at(double r, double angle) const { return centre + r * (M * Vec2(std::cos(angle), std::sin(angle))); }
    /// A function of (u, v), given by its jet there, as one of (r, angle).
    Jet pull_back(const Jet& g, double r, double angle) const {
        const double c = std::cos(angle), s = std::sin(angle);
        const Vec2 m = M * Vec2(c, s), t = M * Vec2(-s, c);  // d/dr and, over r, d/dangle
        const auto second = [&](const Vec2& x, const Vec2& y) {
            return g.aa * x.x() * y.x() + g.ab * (x.x() * y.y() + x.y() * y.x()) + g.bb * x.y() * y.y();
        };
        const double along = g.a * m.x() + g.b * m.y(), across = g.a * t.x() + g.b * t.y();
        return {g.f, along, r * across, second(m, m), r * second(m, t) + across, r * r * second(t, t) - r * along};
    }
};

/// One position: the state of its two stages.
class Position {
public:
    Position(const MultipointSolver::Impl& solver, Scratch& scratch) : s_(solver), tool_(solver.tool), scratch_(scratch) {}

    Result<MultipointPose> drop(double x, double y, const Vec3& feed);
    Result<MultipointPose> at_contact(int face, const Vec2& uv, const Vec3& lean, double start);

private:
    tl::unexpected<Error> failed(std::string_view status, std::string_view stage, std::string what) const {
        return fail(ErrorCode::no_solution, fmt::format("{} at footprint ({:.9g}, {:.9g}), {}: {}", status, pose_.footprint.x(),
                                                        pose_.footprint.y(), stage, what));
    }
    template <class F>
    Minimum polish(const F& f, const Field& field, double u, double v, const Vec3& ring_centre, double reach);
    // stage 1
    std::optional<Jet> depth(const Field& field, double u, double v);
    Spot polish_drop(const Spot& seed);
    void drop_seeds();
    Result<void> first_contact();
    Result<void> take_first(const Vec3& feed);
    // stage 2
    Spot polish_turn(const Spot& seed, bool up, double reach);
    std::vector<Spot> turn_spots(bool up);
    void near_first(bool up, std::vector<Spot>& spots);
    void along_valley(bool up, std::vector<Spot>& spots);
    Result<void> second_contact();
    double merged_limit() const;

    MultipointContact kind_at(const Field& field, const Minimum& m) const {
        (void)field;
        return m.held_a && m.held_b   ? MultipointContact::corner
               : m.held_a || m.held_b ? MultipointContact::edge
                                      : MultipointContact::interior;
    }

    const MultipointSolver::Impl& s_;
    const ToolShape& tool_;
    Scratch& scratch_;
    MultipointPose pose_;
    Vec3 o_ = Vec3::Zero();    // on the footprint axis
    std::vector<Spot> peaks_;  // stage 1, value = -height
    Insert insert_;
    std::optional<Field::Near> near_;
    std::uint32_t P_field_ = 0;
};

/// Newton, first in ring coordinates about `ring_centre` (near the surface, on the tool axis), then in u and v, where the borders
/// are.
template <class F>
Minimum Position::polish(const F& f, const Field& field, double u, double v, const Vec3& ring_centre, double reach) {
    const SurfacePoint p = field.at(u, v);
    int evaluations = 0;
    const Vec3 n = p.Su.cross(p.Sv);
    const double area = n.norm();
    const Vec3 out = p.S - ring_centre;
    // A start on the border is left to u and v.
    const bool border = u <= field.u().lo || u >= field.u().hi || v <= field.v().lo || v >= field.v().hi;
    if (!border && tool_.Ro > 0.0 && area > 1e-9 * (p.Su.squaredNorm() + p.Sv.squaredNorm())) {
        // Tangent plane at the seed: x along the ring's radius.
        const Vec3 normal = n / area, flat = out - out.dot(normal) * normal;
        const double r = flat.norm();
        if (r > 0.25 * tool_.Ro) {
            const Vec3 t1 = flat / r, t2 = normal.cross(t1);
            Eigen::Matrix2d J;
            J << p.Su.dot(t1), p.Sv.dot(t1), p.Su.dot(t2), p.Sv.dot(t2);
            Polar ring;
            ring.M = J.inverse();
            ring.centre = Vec2(u, v) - r * (ring.M * Vec2(1.0, 0.0));
            const auto on_ring = [&](double radius, double angle) -> std::optional<Jet> {
                const Vec2 uv = ring.at(radius, angle);
                if (!field.u().contains(uv.x()) || !field.v().contains(uv.y())) return std::nullopt;
                const auto g = f(uv.x(), uv.y());
                if (!g) return std::nullopt;
                return ring.pull_back(*g, radius, angle);
            };
            const Minimum m = minimise(on_ring, r, 0.0, {{0.05 * r, 4.0 * r}, {-kPi, kPi}}, {1.0, r}, reach, 1e-6);
            evaluations = m.evaluations;
            if (m.defined) {
                const Vec2 uv = ring.at(m.a, m.b);
                u = uv.x();
                v = uv.y();
            }
        }
    }
    Minimum m = minimise(f, u, v, {field.u(), field.v()}, scale_of(field.at(u, v)), reach);
    m.evaluations += evaluations;
    return m;
}

// ---- stage 1 --------------------------------------------------------------------------------------------------------

std::optional<Jet> Position::depth(const Field& field, double u, double v) {
    SurfacePoint p = field.at(u, v);
    p.S -= o_;
    const auto height = touch_height(tool_, s_.ex, s_.ey, s_.ez, p);
    if (!height) return std::nullopt;
    return -*height;
}

Spot Position::polish_drop(const Spot& seed) {
    const Field& field = s_.fields[seed.field];
    const auto f = [&](double u, double v) { return depth(field, u, v); };
    const double reach = 0.25 * (tool_.Ro + tool_.Ri);
    const Vec3 S = field.at(seed.u, seed.v).S;
    Minimum m = polish(f, field, seed.u, seed.v, o_ + (S - o_).dot(s_.ez) * s_.ez, reach);
    pose_.newton_steps += m.evaluations;
    if (!tool_.open && m.defined) {
        // Under the disc the height is that of the surface, with no curvature of the tool's: on nearly flat ground Newton stops
        // short of the rim, just beyond which the top lies. It starts there again, uphill from where it stopped.
        const SurfacePoint p = field.at(m.a, m.b);
        const Vec3 X = p.S - o_;
        const Vec2 x(X.dot(s_.ex), X.dot(s_.ey));
        const Vec2 scale = scale_of(p), g(-m.jet.a / scale.x(), -m.jet.b / scale.y());
        if (x.norm() < tool_.Ro && g.norm() > 0.0 && !(m.held_a && m.held_b)) {
            const Vec2 up = g.normalized();
            const Vec3 step = up.x() * p.Su / scale.x() + up.y() * p.Sv / scale.y();
            const Vec2 d(step.dot(s_.ex), step.dot(s_.ey));
            const double radius = tool_.Ro + tool_.Ri * std::min(0.5, g.norm()), along = x.dot(d), dd = d.squaredNorm();
            const double t = (-along + std::sqrt(along * along + dd * (radius * radius - x.squaredNorm()))) / dd;
            const Minimum again =
                minimise(f, m.a + t * up.x() / scale.x(), m.b + t * up.y() / scale.y(), {field.u(), field.v()}, scale, reach);
            pose_.newton_steps += again.evaluations;
            if (again.defined && again.jet.f < m.jet.f) m = again;
        }
    }
    Spot spot{seed.field, m.a, m.b, m.jet.f, field.at(m.a, m.b).S, m.jet, kind_at(field, m), settled(m)};
    if (!m.defined) spot.value = kInfinity;
    return spot;
}

void Position::drop_seeds() {
    scratch_.seeds.clear();
    const double reach = tool_.Ro + tool_.Ri;
    double best = -kInfinity;
    // A sample misses the top by half a cell at most: by the greatest curvature of the height, 1 / Ri, over a quarter of the
    // cell's diagonal squared; at the wall of the tool by more, but there another sample of the same top serves.
    const double margin = std::min(2.0 * s_.spacing, s_.spacing * s_.spacing / std::max(tool_.Ri, 0.1 * s_.spacing));
    Block heights;
    const Vec3 ax = s_.ex.cwiseAbs(), ay = s_.ey.cwiseAbs();
    s_.tile_tree.visit(
        [&](const BoxNode& node) {
            const Vec3 p = node.centre - o_;
            const double gx = std::max(0.0, std::abs(p.dot(s_.ex)) - ax.dot(node.half)),
                         gy = std::max(0.0, std::abs(p.dot(s_.ey)) - ay.dot(node.half));
            return gx * gx + gy * gy <= reach * reach;
        },
        [&](std::uint32_t index) {
            const Tile& tile = s_.tiles[index];
            const Vec3 p = tile.centre - o_;
            if (p.dot(s_.ez) + tile.radius + tool_.Ri < best - margin) return;
            if (std::hypot(p.dot(s_.ex), p.dot(s_.ey)) > reach + tile.radius) return;
            scan_heights(tool_, tile, o_, s_.ex, s_.ey, s_.ez, heights);
            best = std::max(best, *std::max_element(heights.begin(), heights.end()));
            local_maxima(heights, best - margin, [&](int k) {
                const Field& field = s_.fields[tile.field];
                Spot seed;
                seed.field = tile.field;
                seed.u = field.lattice_u[static_cast<std::size_t>(tile.first_u + k / Tile::kSide - 1)];
                seed.v = field.lattice_v[static_cast<std::size_t>(tile.first_v + k % Tile::kSide - 1)];
                seed.value = -heights[static_cast<std::size_t>(k)];
                scratch_.seeds.push_back(seed);
            });
        });
    std::sort(scratch_.seeds.begin(), scratch_.seeds.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    if (scratch_.seeds.size() > kMostSeeds) scratch_.seeds.resize(kMostSeeds);
}

Result<void> Position::first_contact() {
    drop_seeds();
    peaks_.clear();
    for (std::size_t k = 0; k < scratch_.seeds.size(); ++k) {
        const Spot spot = polish_drop(scratch_.seeds[k]);
        if (std::isfinite(spot.value)) peaks_.push_back(spot);
    }
    // Proof, and repair where it finds the tool too deep. Without one sample under the tool it starts far below everything, where
    // whatever lies under the tool is found as a gouge.
    double height = -kInfinity;
    for (const Spot& p : peaks_) height = std::max(height, -p.value);
    for (int round = 0;; ++round) {
        ToolShape tool = tool_;
        ToolStand stand{o_ + height * s_.ez, s_.ez};
        if (!std::isfinite(height)) {
            stand.C = o_ + s_.lowest(o_) * s_.ez;
            tool.top = kInfinity;
        }
        const Proof proof = prove_clear(s_.scene(), tool, stand, s_.options.certificate, s_.options.most_boxes, scratch_.stack);
        pose_.boxes += proof.boxes;
        if (proof.clear) {
            if (!std::isfinite(height))
                return failed("NoSurfaceUnderTool", "stage 1",
                              "no machined surface lies under the cutter; leave this footprint out, or name the face under it in "
                              "part.faces");
            pose_.certified_gouge = proof.gouge;
            break;
        }
        const Spot found = proof.gouged ? polish_drop(spot_of(*proof.gouged)) : Spot{};
        if (!proof.gouged || round >= kMostRepairs || !(-found.value > height))
            return failed("CertificateFailed", "stage 1",
                          fmt::format("after {} boxes the drop at height {:.9g} mm is proved only to {:.3g} mm", pose_.boxes,
                                      height, proof.gouged ? height + found.value : proof.left));
        peaks_.push_back(found);
        height = -found.value;
    }
    keep_distinct(peaks_);
    if (!peaks_.front().converged)
        return failed("CertificateFailed", "stage 1",
                      "the first contact is not determined: the surface is level to rounding along a ring");
    return {};
}

Result<void> Position::take_first(const Vec3& feed) {
    // Equal heights: the one whose e_v is most across the feed, then the smaller angle.
    std::size_t equal = 1;
    while (equal < peaks_.size() && peaks_[equal].value <= peaks_.front().value + kSameHeight) ++equal;
    const auto flat = [&](const Spot& p) { return Vec3(p.S - o_ - (p.S - o_).dot(s_.ez) * s_.ez); };
    if (equal > 1) {
        const auto rank = [&](const Spot& p) {
            const Vec3 r = flat(p);
            const double along_feed = r.norm() > 0.0 ? std::abs(r.normalized().dot(feed)) : 2.0;
            // Rounding must not decide: a millionth of a degree apart counts as equal.
            return std::pair(std::round(along_feed * 1e8), std::atan2(r.dot(s_.ey), r.dot(s_.ex)));
        };
        std::sort(peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(equal),
                  [&](const Spot& a, const Spot& b) { return rank(a) < rank(b); });
        pose_.ambiguous = true;
    }
    const Spot& first = peaks_.front();
    const Field& field = s_.fields[first.field];
    const Vec3 r = flat(first);
    const double rho = r.norm();
    pose_.z_c = -first.value + o_.dot(s_.ez);
    pose_.P = first.S;
    pose_.P_uv = {first.u, first.v};
    pose_.P_face = field.face();
    pose_.P_kind = first.kind;
    pose_.gap_first = kInfinity;
    for (std::size_t k = equal; k < peaks_.size(); ++k)
        pose_.gap_first = std::min(pose_.gap_first, peaks_[k].value - first.value);
    if (equal > 1) pose_.gap_first = 0.0;
    P_field_ = first.field;

    // Curvatures of the height in a tangent basis.
    pose_.k_min = pose_.k_max = kNaN;
    const SurfacePoint p = field.at(first.u, first.v);
    if (first.kind == MultipointContact::interior) {
        Eigen::Matrix2d G, H;
        G << p.Su.dot(p.Su), p.Su.dot(p.Sv), p.Su.dot(p.Sv), p.Sv.dot(p.Sv);
        H << first.jet.aa, first.jet.ab, first.jet.ab, first.jet.bb;
        const Eigen::Matrix2d inverse = G.llt().matrixL().toDenseMatrix().inverse(), k = inverse * H * inverse.transpose();
        const double half = 0.5 * (k(0, 0) + k(1, 1)), spread = std::hypot(0.5 * (k(0, 0) - k(1, 1)), 0.5 * (k(0, 1) + k(1, 0)));
        pose_.k_min = half - spread;
        pose_.k_max = half + spread;
    }
    const Vec3 C = o_ + -first.value * s_.ez;
    pose_.T = s_.ez;
    pose_.CL = C - tool_.Ri * s_.ez;
    pose_.e_w = s_.ez;
    pose_.Q = Vec3::Constant(kNaN);
    pose_.Q_uv = Vec2::Constant(kNaN);

    const bool on_disc = !tool_.open && rho < tool_.Ro;
    constexpr double kOnAxis = 1e-9;  // mm: nearer the axis its direction is rounding
    const bool on_axis = rho < kOnAxis;
    const Vec3 out = on_axis ? s_.ex : Vec3(r / rho);
    pose_.e_v = -out;
    pose_.insert_centre = C + (on_disc ? rho : tool_.Ro) * out;
    pose_.normal = tool_.Ri > 0.0 ? Vec3((pose_.insert_centre - pose_.P) / tool_.Ri) : s_.ez;
    if (first.kind == MultipointContact::interior) {
        // The contact's normal is the surface's, to rounding; the surface's is the better known of the two.
        const auto n = field.surface().normal(first.u, first.v);
        if (n) pose_.normal = n->dot(pose_.normal) < 0.0 ? Vec3(-*n) : *n;
    }
    pose_.normal.normalize();
    insert_ = Insert::from(pose_.P, pose_.insert_centre, pose_.e_v, pose_.e_w);
    if (tool_.Ro == 0.0) {
        pose_.status = MultipointStatus::ball_has_no_tilt;
        pose_.tilt_minus = -s_.options.max_tilt;
        pose_.tilt_plus = s_.options.max_tilt;
    } else if (equal >= 3) {
        pose_.status = MultipointStatus::circle_contact;
    } else if (equal == 2) {
        pose_.status = MultipointStatus::ambiguous_first_contact;
        pose_.Q = peaks_[1].S;
        pose_.Q_uv = {peaks_[1].u, peaks_[1].v};
        pose_.Q_kind = peaks_[1].kind;
    } else if (on_axis) {
        pose_.status = MultipointStatus::first_contact_on_axis;
    } else if (on_disc) {
        // A whole flat under the disc has no curvature anywhere.
        constexpr double kFlat = 1e-12;  // 1/mm
        pose_.status = std::abs(pose_.k_max) < kFlat ? MultipointStatus::circle_contact : MultipointStatus::disc_contact;
        pose_.P_kind = pose_.P_kind == MultipointContact::interior ? MultipointContact::disc : pose_.P_kind;
    } else {
        pose_.status = MultipointStatus::two_contacts;
    }
    return {};
}

// ---- stage 2 --------------------------------------------------------------------------------------------------------

Spot Position::polish_turn(const Spot& seed, bool up, double reach) {
    const Field& field = s_.fields[seed.field];
    const bool own = seed.field == P_field_;
    const double centre = centre_of(field);
    const auto turn = [&](double u, double v) -> std::optional<Jet> {
        SurfacePoint p = own ? near_->at(u, v) : field.at(u, v);
        if (!own) p.S -= insert_.P;
        if (p.S.squaredNorm() < centre * centre) return std::nullopt;  // the valley's business
        return turn_until(tool_, insert_, p, up);
    };
    const Minimum m = polish(turn, field, seed.u, seed.v, insert_.P + tool_.Ro * insert_.ev, reach);
    pose_.newton_steps += m.evaluations;
    Spot spot{seed.field, m.a, m.b, m.jet.f, field.at(m.a, m.b).S, m.jet, kind_at(field, m), settled(m)};
    if (!m.defined) spot.value = kInfinity;
    return spot;
}

/// A closed tool cannot turn past T = n, where P would pass under the disc; nor back past the tube's equator.
double Position::merged_limit() const {
    return tool_.open ? kInfinity : -0.5 * kPi - std::atan2(insert_.Pw, insert_.Pv);
}

/// Near an interior P the turn has a limit that depends on the direction, and a valley leads from the lowest one to the second
/// contact. Along it in polar coordinates, where the turn is a smooth function of both (section 5.1).
void Position::along_valley(bool up, std::vector<Spot>& spots) {
    const Field& field = s_.fields[P_field_];
    const SurfacePoint p = near_->at(pose_.P_uv.x(), pose_.P_uv.y());
    const Vec3 n = pose_.normal, t2 = n.cross(insert_.eu).normalized(), t1 = insert_.eu;
    Eigen::Matrix2d J;
    J << p.Su.dot(t1), p.Sv.dot(t1), p.Su.dot(t2), p.Sv.dot(t2);
    if (!(std::abs(J.determinant()) > 1e-12 * J.squaredNorm())) return;
    const Eigen::Matrix2d M = J.inverse();
    const auto curvature = [&](const Vec2& x, const Vec2& y) {
        const Vec2 a = M * x, b = M * y;
        return n.dot(p.Suu) * a.x() * b.x() + n.dot(p.Suv) * (a.x() * b.y() + a.y() * b.x()) + n.dot(p.Svv) * a.y() * b.y();
    };
    const Vec2 one(1.0, 0.0), two(0.0, 1.0);
    const double k11 = curvature(one, one), k12 = curvature(one, two), k22 = curvature(two, two);
    const double across = 1.0 - tool_.Ri * k22, lambda = 1.0 - tool_.Ri * k11 - tool_.Ri * tool_.Ri * k12 * k12 / across;
    const double theta0 = std::atan2(tool_.Ri * k12, across);
    if (up && across > 0.0 && lambda > 0.0) {
        const double v = tool_.Ro * (1.0 - 1.0 / lambda);
        if (std::abs(v) <= tool_.Ri) {
            Spot spot{P_field_, pose_.P_uv.x(), pose_.P_uv.y(), 0.0, pose_.P, Jet(), MultipointContact::merged};
            spot.value = -std::acos(v / tool_.Ri) - std::atan2(insert_.Pw, insert_.Pv);
            if (spot.value >= 0.0) spots.push_back(spot);
        }
    }
    const double centre = centre_of(field);
    const Polar about{pose_.P_uv, M};
    const auto polar = [&](double s, double theta) -> std::optional<Jet> {
        if (std::abs(s) < centre) s = s < 0.0 ? -centre : centre;
        const Vec2 uv = about.at(s, theta);
        if (!field.u().contains(uv.x()) || !field.v().contains(uv.y())) return std::nullopt;
        const auto turn = turn_until(tool_, insert_, near_->at(uv.x(), uv.y()), up);
        if (!turn) return std::nullopt;
        return about.pull_back(*turn, s, theta);
    };
    const double far = 2.5 * s_.spacing;
    const Interval angles{theta0 - 0.5 * kPi, theta0 + 0.5 * kPi};
    for (const double side : {-1.0, 1.0}) {
        double theta = theta0;
        Minimum best;
        double s_best = 0.0;
        best.jet.f = kInfinity;
        for (const double part : {0.05, 0.4, 1.0}) {
            const double s = side * part * far;
            const auto start = polar(s, theta);
            if (!start) continue;
            const Minimum m = minimise([&](double a, double b) { return polar(a, b); }, s, theta, {{s, s}, angles},
                                       {1.0, std::abs(s)}, 0.5 * std::abs(s), 1e-2 * std::abs(s));
            pose_.newton_steps += m.evaluations;
            theta = m.b;
            if (m.jet.f < best.jet.f) best = m, s_best = s;
        }
        if (!std::isfinite(best.jet.f)) continue;
        const Minimum m = minimise([&](double a, double b) { return polar(a, b); }, s_best, best.b, {{-far, far}, angles},
                                   {1.0, std::max(0.05 * far, std::abs(s_best))}, 0.5 * far);
        pose_.newton_steps += m.evaluations;
        const Vec2 uv = pose_.P_uv + m.a * (M * Vec2(std::cos(m.b), std::sin(m.b)));
        Spot spot{P_field_,
                  std::clamp(uv.x(), field.u().lo, field.u().hi),
                  std::clamp(uv.y(), field.v().lo, field.v().hi),
                  m.jet.f,
                  Vec3::Zero(),
                  m.jet,
                  MultipointContact::interior,
                  settled(m)};
        spot.S = field.at(spot.u, spot.v).S;
        spots.push_back(spot);
        // The valley may run on beyond, or into the border of the face.
        const bool at_end = std::abs(m.a) >= 0.99 * far;
        const bool at_border =
            !polar(m.a + std::copysign(0.05 * far, m.a), m.b) || !polar(m.a - std::copysign(0.05 * far, m.a), m.b);
        if ((at_end || at_border) && std::abs(m.a) > 0.02 * far) spots.push_back(polish_turn(spot, up, 0.5 * far));
    }
}

/// Around a P on an edge or corner: along the edge the turn has a limit too, elsewhere none; a ring of starts serves.
void Position::near_first(bool up, std::vector<Spot>& spots) {
    const Field& field = s_.fields[P_field_];
    const Vec2 scale = scale_of(near_->at(pose_.P_uv.x(), pose_.P_uv.y()));
    std::vector<Spot> starts;
    for (const double s : {0.05, 0.3, 1.0, 2.0})
        for (int k = 0; k < 8; ++k) {
            const double angle = 0.25 * kPi * k, r = s * s_.spacing;
            Spot spot;
            spot.field = P_field_;
            spot.u = pose_.P_uv.x() + r * std::cos(angle) / scale.x();
            spot.v = pose_.P_uv.y() + r * std::sin(angle) / scale.y();
            if (!field.u().contains(spot.u) || !field.v().contains(spot.v)) continue;
            const auto turn = turn_until(tool_, insert_, near_->at(spot.u, spot.v), up);
            if (!turn) continue;
            spot.value = turn->f;
            starts.push_back(spot);
        }
    std::sort(starts.begin(), starts.end(),
              [](const Spot& a, const Spot& b) { return std::tie(a.value, a.u, a.v) < std::tie(b.value, b.u, b.v); });
    constexpr std::size_t kBest = 4;
    for (std::size_t k = 0; k < std::min(kBest, starts.size()); ++k)
        spots.push_back(polish_turn(starts[k], up, 0.3 * s_.spacing));
}

std::vector<Spot> Position::turn_spots(bool up) {
    std::vector<Spot> spots;
    const double limit = s_.options.max_tilt;
    if (up) {  // the other way the limit near P is that of P itself, at the tube's equator
        if (pose_.P_kind == MultipointContact::interior)
            along_valley(up, spots);
        else
            near_first(up, spots);
    }
    double least = limit;
    for (const Spot& s : spots)
        if (std::isfinite(s.value)) least = std::min(least, s.value);
    if (up) least = std::min(least, merged_limit());

    scratch_.seeds.clear();
    const double D2 = tool_.Ro + tool_.Ri, torus = 2.0 * tool_.Ro + tool_.Ri, wall = std::hypot(tool_.Ro + D2, tool_.top);
    // A cell of samples hides a dip of the turn of some degrees per mm (section 9); what is worse by more is no candidate.
    const double margin = std::min(0.3, 0.06 * s_.spacing);
    Block cosines;
    s_.tile_tree.visit(
        [&](const BoxNode& node) {
            const Vec3 gap = ((insert_.O1 - node.centre).cwiseAbs() - node.half).cwiseMax(0.0);
            return gap.squaredNorm() <= wall * wall;
        },
        [&](std::uint32_t index) {
            const Tile& tile = s_.tiles[index];
            const Vec3 c = tile.centre - insert_.O1;
            const double distance = c.norm() - tile.radius;
            const double reach = std::min(limit, least + margin);
            const double most = c.norm() + tile.radius, highest = c.dot(insert_.ew) + tile.radius;
            if (distance > wall) return;
            // From below a wall is met only by what comes to lie above the torus centre on the way.
            const bool walls = !up || highest >= -most * std::sin(std::min(0.5 * kPi, reach));
            if (distance > torus && !walls) return;
            // The other way everything is met at w >= 0 and v >= -Ri, after passing below: the way there, from the point's angle
            // below the horizontal, is at least a quarter turn less asin(Ri / R).
            if (!up) {
                const double nearest = std::max(distance, tool_.Ri);
                const double below = std::max(0.0, reach - 0.5 * kPi + std::asin(tool_.Ri / nearest));
                if (highest < -most * std::sin(below)) return;
            }
            // No point of the tile moves farther against the tool than its distance from the line times the turn.
            if (tool_distance(tool_, {insert_.O1 + tool_.Ro * insert_.ev, insert_.ew}, tile.centre) - tile.radius > most * reach)
                return;
            scan_turns(tool_, tile, insert_, up, walls, 1.5 * s_.spacing, cosines);
            local_maxima(cosines, std::cos(std::min(kPi, reach)), [&](int k) {
                const Field& field = s_.fields[tile.field];
                Spot seed;
                seed.field = tile.field;
                seed.u = field.lattice_u[static_cast<std::size_t>(tile.first_u + k / Tile::kSide - 1)];
                seed.v = field.lattice_v[static_cast<std::size_t>(tile.first_v + k % Tile::kSide - 1)];
                seed.value = std::acos(std::min(1.0, cosines[static_cast<std::size_t>(k)]));
                scratch_.seeds.push_back(seed);
                least = std::min(least, seed.value);
            });
        });
    std::sort(scratch_.seeds.begin(), scratch_.seeds.end(), [](const Spot& a, const Spot& b) {
        return std::tie(a.value, a.field, a.u, a.v) < std::tie(b.value, b.field, b.u, b.v);
    });
    if (scratch_.seeds.size() > kMostSeeds) scratch_.seeds.resize(kMostSeeds);
    for (std::size_t k = 0; k < scratch_.seeds.size(); ++k) {
        if (scratch_.seeds[k].value > least + margin) break;
        spots.push_back(polish_turn(scratch_.seeds[k], up, 2.0 * s_.spacing));
    }
    std::erase_if(spots, [](const Spot& s) { return !std::isfinite(s.value); });
    for (Spot& s : spots) s.value = std::max(0.0, s.value);
    keep_distinct(spots);
    return spots;
}

Result<void> Position::second_contact() {
    std::optional<Vec3> n;
    if (pose_.P_kind == MultipointContact::interior) n = pose_.normal;
    near_.emplace(s_.fields[P_field_], pose_.P_uv.x(), pose_.P_uv.y(), n);

    // The other way first: its limit is only reported.
    const double limit = s_.options.max_tilt;
    pose_.tilt_minus = -limit;
    for (const Spot& s : turn_spots(false)) pose_.tilt_minus = std::max(pose_.tilt_minus, -s.value);
    pose_.tilt_minus = std::min(0.0, std::max(pose_.tilt_minus, -(kPi + std::atan2(insert_.Pw, insert_.Pv))));

    std::vector<Spot> spots = turn_spots(true);
    const double merged = merged_limit();
    for (int round = 0;; ++round) {
        double turn = std::min(limit, merged);
        if (!spots.empty()) turn = std::min(turn, spots.front().value);
        turn = std::max(0.0, turn);
        const Proof proof = prove_clear(s_.scene(), tool_, insert_.stand(tool_, turn), s_.options.certificate,
                                        s_.options.most_boxes, scratch_.stack);
        pose_.boxes += proof.boxes;
        pose_.tilt = pose_.tilt_plus = turn;
        if (proof.clear) {
            pose_.certified_gouge = proof.gouge;
            break;
        }
        Spot found;
        found.value = kInfinity;
        if (proof.gouged) found = polish_turn(spot_of(*proof.gouged), true, 2.0 * s_.spacing);
        if (round >= kMostRepairs || !(found.value < turn))
            return failed(
                "CertificateFailed", "stage 2",
                fmt::format("after {} boxes the tilt of {:.9g} deg is proved only to {:.3g} mm", pose_.boxes, degrees(turn),
                            proof.gouged ? tool_distance(tool_, insert_.stand(tool_, turn),
                                                         s_.fields[proof.gouged->field].at(proof.gouged->u, proof.gouged->v).S)
                                         : proof.left));
        found.value = std::max(0.0, found.value);
        spots.push_back(found);
        keep_distinct(spots);
    }

    pose_.gap_second = kInfinity;
    const double turn = pose_.tilt;
    if (!spots.empty() && spots.front().value <= turn) {
        const Spot& second = spots.front();
        if (!second.converged)
            return failed("CertificateFailed", "stage 2",
                          fmt::format("the tilt is not determined near {:.9g} deg", degrees(turn)));
        pose_.Q = second.S;
        pose_.Q_uv = {second.u, second.v};
        pose_.Q_kind = second.kind;
        if (spots.size() > 1) pose_.gap_second = spots[1].value - second.value;
        pose_.status = MultipointStatus::two_contacts;
        double spread = 0.0;
        std::size_t equal = 0;
        for (const Spot& s : spots)
            if (s.value <= second.value + kSameTurn) ++equal, spread = std::max(spread, (s.S - second.S).norm());
        if (equal >= 3 && spread > 0.5 * tool_.Ro) pose_.status = MultipointStatus::circle_contact;
        if ((pose_.Q - pose_.P).norm() < std::max(kMergedDistance, 1.01 * centre_of(s_.fields[P_field_])) &&
            pose_.status == MultipointStatus::two_contacts) {
            pose_.status = MultipointStatus::merged_contacts;
            pose_.Q_kind = MultipointContact::merged;
        }
    } else if (merged <= limit && turn == std::max(0.0, merged)) {
        pose_.status = MultipointStatus::merged_contacts;
        pose_.Q = pose_.P;
        pose_.Q_uv = pose_.P_uv;
        pose_.Q_kind = MultipointContact::merged;
        if (!spots.empty()) pose_.gap_second = spots.front().value - turn;
    } else {
        pose_.status = MultipointStatus::no_second_contact;
    }
    pose_.turn_to(turn, tool_.Ro, tool_.Ri);
    return {};
}

Result<MultipointPose> Position::drop(double x, double y, const Vec3& feed) {
    pose_.footprint = {x, y};
    if (!std::isfinite(x) || !std::isfinite(y))
        return fail(ErrorCode::invalid_input, fmt::format("NonFinite: footprint ({}, {}) is no point", x, y));
    o_ = x * s_.ex + y * s_.ey;
    if (auto done = first_contact(); !done) return fail_up(std::move(done));
    if (auto done = take_first(feed); !done) return fail_up(std::move(done));
    if (pose_.status == MultipointStatus::two_contacts)
        if (auto done = second_contact(); !done) return fail_up(std::move(done));
    if (!pose_.CL.allFinite() || !pose_.T.allFinite())
        return fail(ErrorCode::internal, fmt::format("NonFinite at footprint ({:.9g}, {:.9g}): the pose has no numbers", x, y));
    return pose_;
}

Result<MultipointPose> Position::at_contact(int face, const Vec2& uv, const Vec3& lean, double start) {
    const auto it = std::find_if(s_.fields.begin(), s_.fields.end(), [&](const Field& f) {
        return f.face() == face && f.u().contains(uv.x()) && f.v().contains(uv.y());
    });
    if (it == s_.fields.end())
        return fail(ErrorCode::invalid_input,
                    fmt::format("contact ({:.9g}, {:.9g}) is no point of face {} among the machined ones", uv.x(), uv.y(), face));
    P_field_ = static_cast<std::uint32_t>(it - s_.fields.begin());
    const auto n = it->surface().normal(uv.x(), uv.y());
    if (!n)
        return failed("DegenerateSurface", "contact",
                      fmt::format("the surface has no normal at ({:.9g}, {:.9g})", uv.x(), uv.y()));
    const Vec3 side = lean - lean.dot(*n) * *n;
    if (!(side.norm() > 1e-9))
        return fail(ErrorCode::invalid_input, "the direction in which the tool leans lies along the surface normal");
    const Vec3 m = side.normalized();
    pose_.P = it->at(uv.x(), uv.y()).S;
    pose_.normal = *n;
    pose_.P_uv = uv;
    pose_.P_face = face;
    pose_.P_kind = MultipointContact::interior;
    pose_.gap_first = kInfinity;
    pose_.k_min = pose_.k_max = kNaN;
    pose_.z_c = kNaN;
    pose_.Q = Vec3::Constant(kNaN);
    pose_.Q_uv = Vec2::Constant(kNaN);
    const double c = std::cos(start), s = std::sin(start);
    pose_.e_w = c * *n + s * m;
    pose_.e_v = s * *n - c * m;
    pose_.insert_centre = pose_.P + tool_.Ri * *n;
    pose_.footprint = {pose_.insert_centre.dot(s_.ex), pose_.insert_centre.dot(s_.ey)};
    insert_ = Insert::from(pose_.P, pose_.insert_centre, pose_.e_v, pose_.e_w);
    const Proof proof =
        prove_clear(s_.scene(), tool_, insert_.stand(tool_, 0.0), s_.options.certificate, s_.options.most_boxes, scratch_.stack);
    pose_.boxes += proof.boxes;
    if (!proof.clear)
        return failed(
            "GougeAtStart", "contact",
            fmt::format("already at {:.6g} deg from the normal the cutter gouges; start nearer the normal or lean another way",
                        degrees(start)));
    if (auto done = second_contact(); !done) return fail_up(std::move(done));
    return pose_;
}

Scratch& scratch() {
    thread_local Scratch mine;
    return mine;
}

}  // namespace

void MultipointPose::turn_to(double angle, double R_major, double R_minor) {
    const double c = std::cos(angle), s = std::sin(angle);
    tilt = angle;
    T = (c * e_w + s * e_v).normalized();
    CL = insert_centre + R_major * (c * e_v - s * e_w) - R_minor * T;
}

void MultipointSolver::Impl::prepare() {
    std::vector<Box3> boxes;
    for (std::size_t f = 0; f < fields.size(); ++f) fields[f].append_tiles(static_cast<std::uint32_t>(f), tiles);
    for (const Tile& t : tiles) {
        Box3 box;
        for (int k = 0; k < Tile::kSize; ++k) {
            const auto at = static_cast<std::size_t>(k);
            if (t.x[at] < Tile::kFar) box.add(Vec3(t.x[at], t.y[at], t.z[at]));
        }
        boxes.push_back(box);
    }
    tile_tree = BoxTree(boxes, 1);
    boxes.clear();
    for (std::size_t f = 0; f < fields.size(); ++f)
        for (std::size_t s = 0; s < fields[f].spans(); ++s) {
            roots.push_back({static_cast<std::uint32_t>(f), static_cast<std::uint32_t>(s), 0.0, 0.0, 1.0, 0});
            boxes.push_back(fields[f].span_box(s));
            whole.add(boxes.back());
        }
    span_tree = BoxTree(boxes, 1);
}

double MultipointSolver::Impl::lowest(const Vec3& o) const {
    return (whole.centre() - o).dot(ez) - ez.cwiseAbs().dot(whole.half()) - 2.0 * (tool.Ro + tool.Ri);
}

Result<MultipointPose> MultipointSolver::drop(double x, double y, const Vec3& feed) const {
    return Position(*impl_, scratch()).drop(x, y, feed);
}

Result<MultipointPose> MultipointSolver::at_contact(int face, const Vec2& uv, const Vec3& lean, double start) const {
    return Position(*impl_, scratch()).at_contact(face, uv, lean, start);
}

std::optional<double> MultipointSolver::certify(const Vec3& tip, const Vec3& axis, double eps) const {
    const Proof proof = prove_clear(impl_->scene(), impl_->tool, {tip + impl_->tool.Ri * axis, axis}, eps,
                                    impl_->options.most_boxes, scratch().stack);
    return proof.clear ? std::optional<double>(proof.gouge) : std::nullopt;
}

Result<std::vector<Result<MultipointPose>>> MultipointSolver::drop_all(std::span<const Vec2> footprints,
                                                                       std::span<const Vec3> feeds,
                                                                       const Control& control) const {
    TRUNNION_REQUIRE(feeds.empty() || feeds.size() == footprints.size());
    std::vector<Result<MultipointPose>> poses(footprints.size(), fail(ErrorCode::internal, "not computed"));
    constexpr std::size_t kGrain = 16;
    auto done =
        parallel_for(footprints.size(), kGrain, control, "two-point positioning", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                poses[i] = drop(footprints[i].x(), footprints[i].y(), feeds.empty() ? Vec3(Vec3::Zero()) : feeds[i]);
        });
    if (!done) return fail_up(std::move(done));
    return poses;
}

}  // namespace trunnion
