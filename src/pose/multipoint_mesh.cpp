#include "trunnion/pose/multipoint_mesh.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "pose/multipoint_impl.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

using namespace detail;

namespace {
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
}  // namespace

/// Everything in the drop frame: z is T0.
struct MeshPositioner::Impl {
    ToolShape tool;
    MultipointOptions options;
    Mat3 frame;  // rows: x, y, z of the drop frame
    struct Facet {
        Vec3 a, b, c, n;  // corners, unit normal (zero for a degenerate one)
        std::uint32_t face = 0, triangle = 0;
    };
    std::vector<Facet> facets;  // in the order of the tree
    BoxTree tree;
    /// Over a node: z <= z0 + slope . (xy - centre) + above.
    struct Cover {
        double z0 = 0.0, slope_x = 0.0, slope_y = 0.0, above = 0.0;
    };
    std::vector<Cover> covers;

    double g(double rho) const {
        const double t = tool.open ? rho - tool.Ro : std::max(0.0, rho - tool.Ro);
        const double q = tool.Ri * tool.Ri - t * t;
        return q >= 0.0 ? std::sqrt(q) : -kInfinity;
    }
    /// Upper bound of the height over a node.
    double bound(std::uint32_t node, double x, double y) const {
        const BoxNode& box = tree.nodes()[node];
        const double dx = box.centre.x() - x, dy = box.centre.y() - y;
        const double gx = std::max(0.0, std::abs(dx) - box.half.x()), gy = std::max(0.0, std::abs(dy) - box.half.y());
        const double nearest = std::sqrt(gx * gx + gy * gy);
        if (nearest > tool.Ro + tool.Ri) return -kInfinity;
        const double plain = box.centre.z() + box.half.z() + (tool.open ? tool.Ri : g(nearest));
        if (tool.open) return plain;
        // z + g(rho) is concave over the covering plane, because g falls and is concave and rho is convex: its tangent at the
        // centre lies above it.
        const Cover& cover = covers[node];
        const double rho = std::sqrt(dx * dx + dy * dy), t = std::max(0.0, rho - tool.Ro), q = tool.Ri * tool.Ri - t * t;
        if (!(q > 1e-6 * tool.Ri * tool.Ri)) return plain;
        const double height = std::sqrt(q), fall = t > 0.0 ? t / (height * rho) : 0.0;
        const double tangent = cover.z0 + cover.above + height + std::abs(cover.slope_x - fall * dx) * box.half.x() +
                               std::abs(cover.slope_y - fall * dy) * box.half.y();
        return std::min(plain, tangent);
    }
    void cover_nodes();
};

namespace {

using Impl = MeshPositioner::Impl;
using Facet = Impl::Facet;

struct Best {
    double value = -kInfinity;
    Vec3 P = Vec3::Zero();
    MultipointContact kind = MultipointContact::none;
    std::uint32_t facet = 0;

    void offer(double v, const Vec3& p, MultipointContact k, std::uint32_t f) {
        if (v > value) value = v, P = p, kind = k, facet = f;
    }
};

/// Barycentric signs of p over the triangle, seen along the drop axis: bit k set where p lies beyond the side opposite corner k.
unsigned beyond(const Facet& f, double x, double y) {
    const auto side = [&](const Vec3& p, const Vec3& q) { return (q.x() - p.x()) * (y - p.y()) - (q.y() - p.y()) * (x - p.x()); };
    const double area = (f.b.x() - f.a.x()) * (f.c.y() - f.a.y()) - (f.b.y() - f.a.y()) * (f.c.x() - f.a.x());
    const double sign = area < 0.0 ? -1.0 : 1.0;
    return (sign * side(f.b, f.c) < 0.0 ? 1u : 0u) | (sign * side(f.c, f.a) < 0.0 ? 2u : 0u) |
           (sign * side(f.a, f.b) < 0.0 ? 4u : 0u);
}

/// Highest rest along an edge.
void rest_on_edge(const Impl& m, double x, double y, const Vec3& a, const Vec3& b, std::uint32_t facet, Best& best) {
    const ToolShape& tool = m.tool;
    const double hx = b.x() - a.x(), hy = b.y() - a.y(), hh = hx * hx + hy * hy;
    const auto at = [&](double t) { return Vec3(a + t * (b - a)); };
    const auto value = [&](const Vec3& p) {
        return p.z() + m.g(std::sqrt((p.x() - x) * (p.x() - x) + (p.y() - y) * (p.y() - y)));
    };
    const auto offer = [&](double t) {
        const Vec3 p = t <= 0.0 ? a : t >= 1.0 ? b : at(t);
        best.offer(value(p), p, t <= 0.0 || t >= 1.0 ? MultipointContact::vertex : MultipointContact::edge, facet);
    };
    offer(0.0);
    offer(1.0);
    if (!(hh > 0.0)) return;
    // Where the edge lies under the tool.
    const double s0 = ((x - a.x()) * hx + (y - a.y()) * hy) / hh;
    const double across2 =
        std::max(0.0, (a.x() + s0 * hx - x) * (a.x() + s0 * hx - x) + (a.y() + s0 * hy - y) * (a.y() + s0 * hy - y));
    const double D2 = tool.Ro + tool.Ri, room = D2 * D2 - across2;
    if (!(room > 0.0)) return;
    const double reach = std::sqrt(room / hh), lo = std::max(0.0, s0 - reach), hi = std::min(1.0, s0 + reach);
    if (!(lo < hi)) return;
    const double rise = b.z() - a.z();
    // Derivative along the edge, and by the way whether it is defined.
    const auto slope = [&](double t) {
        const double px = a.x() + t * hx - x, py = a.y() + t * hy - y, rho = std::sqrt(px * px + py * py);
        const double off = tool.open ? rho - tool.Ro : std::max(0.0, rho - tool.Ro), q = tool.Ri * tool.Ri - off * off;
        const double along = px * hx + py * hy;
        if (off == 0.0 || !(rho > 0.0)) return rise;
        if (!(q > 0.0)) return off * along > 0.0 ? -kInfinity : kInfinity;
        return rise - off / std::sqrt(q) * along / rho;
    };
    // Concave in each piece (a closed tool has one): the root of the slope by regula falsi with halving.
    const auto search = [&](double p, double q) {
        double fp = slope(p), fq = slope(q);
        if (fp <= 0.0) return offer(p);
        if (fq >= 0.0) return offer(q);
        constexpr int kMost = 100;
        int side = 0;
        double t = 0.5 * (p + q);
        for (int k = 0; k < kMost && q - p > 1e-15; ++k) {
            t = std::isfinite(fp) && std::isfinite(fq) && k % 4 != 3 ? (p * fq - q * fp) / (fq - fp) : 0.5 * (p + q);
            const double ft = slope(t);
            if (ft == 0.0) break;
            if (ft > 0.0) {
                p = t, fp = ft;
                if (side == 1) fq *= 0.5;
                side = 1;
            } else {
                q = t, fq = ft;
                if (side == -1) fp *= 0.5;
                side = -1;
            }
        }
        offer(t);
    };
    if (!tool.open) return search(lo, hi);
    // Over the hollow middle the height is not concave: it is cut where rho = Ro and, within, in short pieces.
    std::vector<double> cuts{lo, hi};
    const double inner = tool.Ro * tool.Ro - across2;
    if (inner > 0.0) {
        constexpr int kPieces = 16;
        const double half = std::sqrt(inner / hh);
        for (int k = 0; k <= kPieces; ++k) cuts.push_back(std::clamp(s0 + half * (2.0 * k / kPieces - 1.0), lo, hi));
    }
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k)
        if (cuts[k] < cuts[k + 1]) search(cuts[k], cuts[k + 1]);
}

/// Highest rest on one triangle.
void rest_on_facet(const Impl& m, double x, double y, std::uint32_t index, Best& best) {
    const Facet& f = m.facets[index];
    const ToolShape& tool = m.tool;
    const double flat = std::sqrt(f.n.x() * f.n.x() + f.n.y() * f.n.y());
    unsigned sides = 7u;
    const double nz = std::abs(f.n.z()), up = f.n.z() < 0.0 ? -1.0 : 1.0;
    // A level facet touches along a circle, a vertical one nowhere inside.
    constexpr double kLevel = 1e-14;
    if (nz > 1e-12) {
        const Vec3 n = up * f.n;
        if (flat > kLevel) {
            // Uphill under the tube (section 10). Normals may point down on an open mesh: both sides are ground.
            const double ex = -n.x() / flat, ey = -n.y() / flat;
            const double d0 = n.dot(f.a), z = (d0 + tool.Ri - n.x() * (x + tool.Ro * ex) - n.y() * (y + tool.Ro * ey)) / n.z();
            if (z <= best.value) return;  // the plane's own rest is the highest the triangle can give
            const Vec3 P = Vec3(x + tool.Ro * ex, y + tool.Ro * ey, z) - tool.Ri * n;
            const unsigned outside = beyond(f, P.x(), P.y());
            if (outside == 0u) {
                best.offer(z, P, MultipointContact::facet, index);
                if (!tool.open) return;
            }
            // A concave function grows towards the top of the plane: the triangle's own top lies on a side that faces it.
            if (!tool.open) sides = outside;
        } else if (!tool.open && beyond(f, x, y) == 0u) {
            best.offer(f.a.z() + tool.Ri, Vec3(x, y, f.a.z()), MultipointContact::facet, index);
            return;
        }
    }
    if (sides & 1u) rest_on_edge(m, x, y, f.b, f.c, index, best);
    if (sides & 2u) rest_on_edge(m, x, y, f.c, f.a, index, best);
    if (sides & 4u) rest_on_edge(m, x, y, f.a, f.b, index, best);
}

/// Best first along one branch, the others kept with their bounds.
Best find_rest(const Impl& m, double x, double y) {
    Best best;
    if (m.tree.empty()) return best;
    struct Open {
        std::uint32_t node;
        double bound;
    };
    Open stack[64];
    int top = 0;
    stack[top++] = {0, m.bound(0, x, y)};
    while (top > 0) {
        const Open at = stack[--top];
        if (!(at.bound > best.value)) continue;
        const BoxNode& node = m.tree.nodes()[at.node];
        if (node.count > 0) {
            for (std::uint32_t k = 0; k < node.count; ++k) rest_on_facet(m, x, y, node.first + k, best);
            continue;
        }
        Open left{at.node + 1, m.bound(at.node + 1, x, y)}, right{node.first, m.bound(node.first, x, y)};
        if (left.bound > right.bound) std::swap(left, right);
        stack[top++] = left;
        stack[top++] = right;
    }
    return best;
}

/// Least tilt at which the turning tool meets a triangle.
struct Second {
    double tilt;
    Vec3 Q = Vec3::Constant(kNaN);
    MultipointContact kind = MultipointContact::none;

    void offer(double t, const Vec3& p, MultipointContact k) {
        if (t < tilt) tilt = t, Q = p, kind = k;
    }
};

std::optional<Jet> turn_at(const Impl& m, const Insert& frame, const Vec3& S, const Vec3& direction) {
    SurfacePoint p;
    p.S = S - frame.P;
    p.Su = direction;
    p.Sv = p.Suu = p.Suv = p.Svv = Vec3::Zero();
    constexpr double kSelf = 1e-7;  // mm: P itself
    if (p.S.squaredNorm() < kSelf * kSelf) return std::nullopt;
    return turn_until(m.tool, frame, p, true);
}

void turn_to_edge(const Impl& m, const Insert& frame, const Vec3& a, const Vec3& b, Second& best) {
    const Vec3 d = b - a;
    const double length = d.norm();
    if (!(length > 0.0)) return;
    constexpr int kSamples = 5;
    std::optional<double> start;
    double least = kInfinity;
    for (int k = 0; k < kSamples; ++k) {
        const double t = k / (kSamples - 1.0);
        const auto turn = turn_at(m, frame, a + t * d, Vec3::Zero());
        if (turn && turn->f < least) least = turn->f, start = t;
    }
    if (!start || least > best.tilt + radians(5.0)) return;
    const Minimum found = minimise([&](double t, double) { return turn_at(m, frame, a + t * d, d); }, *start, 0.0,
                                   {{0.0, 1.0}, {0.0, 0.0}}, {length, 1.0}, 0.25 * length);
    if (found.defined)
        best.offer(std::max(0.0, found.jet.f), a + found.a * d,
                   found.a <= 0.0 || found.a >= 1.0 ? MultipointContact::vertex : MultipointContact::edge);
}

void turn_to_facet(const Impl& m, const Insert& frame, const Facet& f, Second& best) {
    for (const Vec3* v : {&f.a, &f.b, &f.c}) {
        const auto turn = turn_at(m, frame, *v, Vec3::Zero());
        if (turn) best.offer(std::max(0.0, turn->f), *v, MultipointContact::vertex);
    }
    turn_to_edge(m, frame, f.a, f.b, best);
    turn_to_edge(m, frame, f.b, f.c, best);
    turn_to_edge(m, frame, f.c, f.a, best);
    // Tangency with the plane is linear in n . e_v(beta) (section 10).
    const Vec3 n = f.n.z() < 0.0 ? Vec3(-f.n) : f.n;
    const ToolShape& tool = m.tool;
    const double e0 = n.dot(frame.O1 - f.a) - tool.Ri;
    constexpr double kHolds = 1e-9;  // mm: the facet that holds P limits the turn at T = n, which the caller knows
    if (!(e0 > kHolds)) return;
    const double nu = n.dot(frame.eu), nv = n.dot(frame.ev), nw = n.dot(frame.ew);
    const double q = (tool.Ro * tool.Ro * nu * nu - e0 * e0) / (2.0 * e0 * tool.Ro), N = std::sqrt(nv * nv + nw * nw);
    if (std::abs(q) > N) return;
    for (const double sign : {1.0, -1.0}) {
        double beta = sign * std::acos(q / N) - std::atan2(nw, nv);
        beta = std::fmod(beta + 4.0 * kPi, 2.0 * kPi);
        if (!(beta < best.tilt)) continue;
        const ToolStand stand = frame.stand(tool, beta);
        const Vec3 across = n - n.dot(stand.T) * stand.T;
        if (!(across.norm() > 0.0)) continue;
        const Vec3 Q = stand.C - tool.Ro * across.normalized() - tool.Ri * n;
        if (std::abs(n.dot(Q - f.a)) > 1e-7) continue;  // tangent from the wrong side
        if (beyond(f, Q.x(), Q.y()) == 0u) best.offer(beta, Q, MultipointContact::facet);
    }
}

Second find_second(const Impl& m, const Insert& frame, double limit) {
    Second best{limit};
    const auto& nodes = m.tree.nodes();
    // What is met before the best tilt known lies within the tool standing at that tilt.
    const auto may_be_met = [&](const BoxNode& node) {
        return tool_distance(m.tool, frame.stand(m.tool, best.tilt), node.centre) <= node.half.norm();
    };
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
        const std::uint32_t at = stack.back();
        stack.pop_back();
        const BoxNode& node = nodes[at];
        if (!may_be_met(node)) continue;
        if (node.count > 0) {
            for (std::uint32_t k = 0; k < node.count; ++k) turn_to_facet(m, frame, m.facets[node.first + k], best);
            continue;
        }
        stack.push_back(node.first);
        stack.push_back(at + 1);
    }
    return best;
}

}  // namespace

void MeshPositioner::Impl::cover_nodes() {
    covers.resize(tree.nodes().size());
    // Ranges of facets below each node: leaves know theirs; an inner node spans from its first leaf to its last.
    std::vector<std::uint32_t> first(covers.size()), last(covers.size());
    for (std::size_t k = covers.size(); k-- > 0;) {
        const BoxNode& node = tree.nodes()[k];
        first[k] = node.count > 0 ? node.first : first[k + 1];
        last[k] = node.count > 0 ? node.first + node.count : last[node.first];
    }
    constexpr std::uint32_t kLargest = 4096;  // higher up a plane says nothing
    const auto done = parallel_for(covers.size(), 256, Control{}, "mesh", [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            Cover& cover = covers[k];
            const Vec3& centre = tree.nodes()[k].centre;
            if (last[k] - first[k] <= kLargest) {
                Vec3 n = Vec3::Zero();
                for (std::uint32_t f = first[k]; f < last[k]; ++f) n += facets[f].n.z() < 0.0 ? Vec3(-facets[f].n) : facets[f].n;
                if (n.z() > 0.1 * n.norm()) cover.slope_x = -n.x() / n.z(), cover.slope_y = -n.y() / n.z();
            }
            double above = -kInfinity;
            if (last[k] - first[k] <= kLargest) {
                for (std::uint32_t f = first[k]; f < last[k]; ++f)
                    for (const Vec3* v : {&facets[f].a, &facets[f].b, &facets[f].c})
                        above = std::max(above,
                                         v->z() - cover.slope_x * (v->x() - centre.x()) - cover.slope_y * (v->y() - centre.y()));
            } else {
                above = centre.z() + tree.nodes()[k].half.z();
            }
            cover.z0 = above;
            cover.above = 0.0;
        }
    });
    TRUNNION_REQUIRE(done.has_value());
}

Result<MeshPositioner> MeshPositioner::build(const Mesh& mesh, const std::vector<int>& faces, const Cutter& cutter,
                                             const MultipointOptions& options) {
    auto tool = tool_of(cutter, options);
    if (!tool) return fail_up(std::move(tool));
    auto impl = std::make_shared<Impl>();
    impl->tool = *tool;
    impl->options = options;
    const Vec3 ex = any_perpendicular(options.drop_axis);
    impl->frame.row(0) = ex.transpose();
    impl->frame.row(1) = options.drop_axis.cross(ex).transpose();
    impl->frame.row(2) = options.drop_axis.transpose();
    std::vector<Facet> facets;
    std::vector<Box3> boxes;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!faces.empty() && std::find(faces.begin(), faces.end(), static_cast<int>(mesh.face[t])) == faces.end()) continue;
        Facet f;
        f.a = impl->frame * mesh.vertices[mesh.triangles[t][0]];
        f.b = impl->frame * mesh.vertices[mesh.triangles[t][1]];
        f.c = impl->frame * mesh.vertices[mesh.triangles[t][2]];
        const Vec3 n = (f.b - f.a).cross(f.c - f.a);
        f.n = n.norm() > 0.0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
        f.face = mesh.face.empty() ? 0 : mesh.face[t];
        f.triangle = static_cast<std::uint32_t>(t);
        Box3 box;
        for (const Vec3* v : {&f.a, &f.b, &f.c}) box.add(*v);
        facets.push_back(f);
        boxes.push_back(box);
    }
    if (facets.empty())
        return fail(ErrorCode::invalid_input, "orientation.method = \"multipoint\" needs at least one triangle to machine");
    constexpr std::uint32_t kLeaf = 4;
    impl->tree = BoxTree(boxes, kLeaf);
    for (const std::uint32_t k : impl->tree.order()) impl->facets.push_back(facets[k]);
    impl->cover_nodes();
    return MeshPositioner(std::move(impl));
}

Result<MeshPositioner::Rest> MeshPositioner::rest(double x, double y) const {
    const Best best = find_rest(*impl_, x, y);
    if (!std::isfinite(best.value))
        return fail(
            ErrorCode::no_solution,
            fmt::format("NoSurfaceUnderTool at footprint ({:.9g}, {:.9g}), stage 1: no machined triangle lies under the cutter",
                        x, y));
    return Rest{best.value, impl_->frame.transpose() * best.P, best.kind, impl_->facets[best.facet].triangle};
}

Result<MultipointPose> MeshPositioner::drop(double x, double y, const Vec3&) const {
    if (!std::isfinite(x) || !std::isfinite(y))
        return fail(ErrorCode::invalid_input, fmt::format("NonFinite: footprint ({}, {}) is no point", x, y));
    const Impl& m = *impl_;
    const ToolShape& tool = m.tool;
    const Best best = find_rest(m, x, y);
    if (!std::isfinite(best.value))
        return fail(
            ErrorCode::no_solution,
            fmt::format("NoSurfaceUnderTool at footprint ({:.9g}, {:.9g}), stage 1: no machined triangle lies under the cutter",
                        x, y));
    MultipointPose pose;
    pose.footprint = {x, y};
    pose.z_c = best.value;
    pose.P_kind = best.kind;
    pose.P_face = static_cast<int>(m.facets[best.facet].face);
    pose.P_uv = pose.Q_uv = Vec2::Constant(kNaN);
    pose.k_min = pose.k_max = kNaN;
    pose.gap_first = pose.gap_second = kNaN;
    const Vec3 C(x, y, best.value), r(best.P.x() - x, best.P.y() - y, 0.0);
    const double rho = r.norm();
    const bool on_disc = !tool.open && rho < tool.Ro, on_axis = rho < 1e-9;
    const Vec3 out = on_axis ? Vec3(Vec3::UnitX()) : Vec3(r / rho), O1 = C + (on_disc ? rho : tool.Ro) * out;
    const Insert frame = Insert::from(best.P, O1, -out, Vec3::UnitZ());
    const auto world = [&](const Vec3& v) { return Vec3(m.frame.transpose() * v); };
    pose.P = world(best.P);
    pose.normal = world((O1 - best.P).normalized());
    pose.insert_centre = world(O1);
    pose.e_v = world(-out);
    pose.e_w = world(Vec3::UnitZ());
    pose.Q = Vec3::Constant(kNaN);
    double tilt = 0.0;
    if (tool.Ro == 0.0) {
        pose.status = MultipointStatus::ball_has_no_tilt;
    } else if (on_axis) {
        pose.status = MultipointStatus::first_contact_on_axis;
    } else if (on_disc) {
        pose.status = MultipointStatus::disc_contact;
    } else {
        // A closed tool cannot pass T = n at P (section 5.2).
        const double merged = tool.open ? kInfinity : std::max(0.0, -0.5 * kPi - std::atan2(frame.Pw, frame.Pv));
        const Second second = find_second(m, frame, std::min(m.options.max_tilt, merged));
        tilt = second.tilt;
        if (second.Q.allFinite()) {
            pose.Q = world(second.Q);
            pose.Q_kind = second.kind;
            pose.status = MultipointStatus::two_contacts;
        } else if (merged <= m.options.max_tilt) {
            pose.Q = pose.P;
            pose.Q_kind = MultipointContact::merged;
            pose.status = MultipointStatus::merged_contacts;
        } else {
            pose.status = MultipointStatus::no_second_contact;
        }
    }
    pose.tilt_plus = tilt;
    pose.turn_to(tilt, tool.Ro, tool.Ri);
    return pose;
}

Result<std::vector<Result<MultipointPose>>> MeshPositioner::drop_all(std::span<const Vec2> footprints,
                                                                     std::span<const Vec3> feeds, const Control& control) const {
    TRUNNION_REQUIRE(feeds.empty() || feeds.size() == footprints.size());
    std::vector<Result<MultipointPose>> poses(footprints.size(), fail(ErrorCode::internal, "not computed"));
    constexpr std::size_t kGrain = 16;
    auto done =
        parallel_for(footprints.size(), kGrain, control, "two-point positioning", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) poses[i] = drop(footprints[i].x(), footprints[i].y());
        });
    if (!done) return fail_up(std::move(done));
    return poses;
}

double MeshPositioner::R_major() const {
    return impl_->tool.Ro;
}
double MeshPositioner::R_minor() const {
    return impl_->tool.Ri;
}

}  // namespace trunnion
