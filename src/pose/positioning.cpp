#include "trunnion/pose/positioning.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace {

/// Footprints with their feed directions, pass by pass.
struct Rows {
    std::vector<Vec2> xy;
    std::vector<Vec3> feed;
    std::vector<std::size_t> ends;  // one past the last of each pass
    bool given = false;             // points of the job: none may be left out
};

Result<Rows> rows_of(const Parallel& p, const Multipoint& method, const PathScene& scene, int refine) {
    if (p.side_step <= 0.0 && p.positions.empty())
        return fail(ErrorCode::invalid_input,
                    "path.side_step_mm or path.positions_mm is missing: the rows of footprints of orientation.method = "
                    "\"multipoint\" need one");
    const Vec3 x = any_perpendicular(method.drop_axis), y = method.drop_axis.cross(x);
    const Vec3 feed = std::cos(p.direction) * x + std::sin(p.direction) * y, side = feed.cross(method.drop_axis);
    Interval along{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}, across = along;
    for (const int f : scene.faces) {
        const Box3& box = scene.part.faces[static_cast<std::size_t>(f)].box;
        for (int k = 0; k < 8; ++k) {
            const Vec3 corner(k & 1 ? box.hi.x() : box.lo.x(), k & 2 ? box.hi.y() : box.lo.y(), k & 4 ? box.hi.z() : box.lo.z());
            along.lo = std::min(along.lo, corner.dot(feed)), along.hi = std::max(along.hi, corner.dot(feed));
            across.lo = std::min(across.lo, corner.dot(side)), across.hi = std::max(across.hi, corner.dot(side));
        }
    }
    along.lo += p.margin, along.hi -= p.margin;
    const double step = (p.step > 0.0 ? p.step : scene.cutter.spec().diameter / 12.0) / refine;
    // A length that is a whole number of steps up to rounding ends on its last footprint.
    constexpr double kWhole = 1e-9;
    const auto count = static_cast<std::size_t>(std::max(0.0, std::floor(along.length() / step + kWhole)));
    std::vector<double> positions = p.positions;
    if (positions.empty()) {
        const int rows = std::max(1, static_cast<int>(std::ceil(across.length() / p.side_step - kWhole)));
        for (int k = 0; k <= rows; ++k) positions.push_back(across.at(static_cast<double>(k) / rows));
    }
    Rows rows;
    for (std::size_t r = 0; r < positions.size(); ++r) {
        const bool back = p.zigzag && r % 2 == 1;
        std::vector<double> t;
        for (std::size_t k = 0; k <= count; ++k) t.push_back(along.lo + step * static_cast<double>(k));
        if (t.back() < along.hi - kWhole * along.length()) t.push_back(along.hi);
        if (back) std::reverse(t.begin(), t.end());
        for (const double at : t) {
            const Vec3 point = at * feed + positions[r] * side;
            rows.xy.emplace_back(point.dot(x), point.dot(y));
            rows.feed.push_back(back ? Vec3(-feed) : feed);
        }
        rows.ends.push_back(rows.xy.size());
    }
    return rows;
}

Rows rows_of(const GivenPoints& p, const Multipoint& method) {
    Rows rows;
    rows.given = true;
    rows.xy = p.xy;
    const Vec3 x = any_perpendicular(method.drop_axis), y = method.drop_axis.cross(x);
    for (std::size_t i = 0; i < p.xy.size(); ++i) {
        const Vec2 d = p.xy[std::min(i + 1, p.xy.size() - 1)] - p.xy[i > 0 ? i - 1 : 0];
        rows.feed.push_back(d.norm() > 0.0 ? Vec3((d.x() * x + d.y() * y).normalized()) : x);
    }
    rows.ends.push_back(p.xy.size());
    return rows;
}

void add(Positioned& all, const MultipointPose& pose, const Vec3& feed, bool given) {
    const Vec3 flat = feed - feed.dot(pose.normal) * pose.normal;
    // A feed along the normal says nothing of the direction on the surface.
    constexpr double kLost = 1e-9;
    const double length = flat.norm();
    all.contacts.cc.push_back(pose.P);
    all.contacts.n.push_back(pose.normal);
    all.contacts.f.push_back(length > kLost ? Vec3(flat / length) : any_perpendicular(pose.normal));
    all.contacts.uv.push_back(pose.P_uv);
    all.contacts.face.push_back(pose.P_face);
    all.contacts.given.push_back(given);
    all.poses.push_back(pose);
}

void close_pass(Positioned& all, std::size_t first, bool closed = false) {
    const std::size_t count = all.poses.size() - first;
    if (count == 0) return;
    all.contacts.passes.push_back({first, count, closed});
    all.cuts.passes.push_back({first, count, PassKind::cut, false});
}

Result<Positioned> drop_rows(const MultipointSolver& solver, const Rows& rows, const Control& control) {
    auto poses = solver.drop_all(rows.xy, rows.feed, control);
    if (!poses) return fail_up(std::move(poses));
    Positioned all;
    std::size_t begin = 0, empty = 0;
    for (const std::size_t end : rows.ends) {
        std::size_t first = all.poses.size();
        for (std::size_t i = begin; i < end; ++i) {
            auto& pose = (*poses)[i];
            if (pose) {
                add(all, *pose, rows.feed[i], false);
                continue;
            }
            const bool nothing = pose.error().message.starts_with("NoSurfaceUnderTool");
            if (rows.given || !nothing) return fail_in(std::move(pose), fmt::format("point {}", i));
            ++empty;
            close_pass(all, first);
            first = all.poses.size();
        }
        close_pass(all, first);
        begin = end;
    }
    if (all.poses.empty())
        return fail(
            ErrorCode::no_solution,
            "no footprint of the path has a machined face under the cutter; check path.positions_mm and orientation.drop_axis");
    if (empty > 0) all.notes.push_back(fmt::format("{} footprints with no machined face under the cutter were left out", empty));
    return all;
}

/// The lean with the two contacts farthest apart: coarse round, then finer about the best. The separation has no derivative where
/// the second contact jumps.
Result<MultipointPose> widest(const MultipointSolver& solver, int face, const Vec2& uv, const Vec3& n, const Vec3& f,
                              double start) {
    constexpr int kRound = 24, kFiner = 6;
    const Vec3 b = n.cross(f);
    Result<MultipointPose> best = fail(ErrorCode::no_solution, "");
    double at = 0.0, reach = -1.0;
    const auto attempt = [&](double yaw) {
        auto pose = solver.at_contact(face, uv, std::cos(yaw) * f + std::sin(yaw) * b, start);
        const double separation = pose && pose->Q.allFinite() ? pose->separation() : 0.0;
        if (!pose) {
            if (!best && reach < 0.0) best = std::move(pose);
            return;
        }
        if (separation > reach) reach = separation, at = yaw, best = std::move(pose);
    };
    for (int k = 0; k < kRound; ++k) attempt(2.0 * kPi * k / kRound - kPi);
    double step = kPi / kRound;
    for (int k = 0; k < kFiner; ++k, step *= 0.5) {
        const double centre = at;
        attempt(centre - step);
        attempt(centre + step);
    }
    return best;
}

Result<Positioned> raise_at(const MultipointSolver& solver, const Multipoint& method, const ContactPath& contacts,
                            const Control& control) {
    std::vector<Result<MultipointPose>> poses(contacts.size(), fail(ErrorCode::internal, "not computed"));
    constexpr std::size_t kGrain = 16;
    auto done = parallel_for(contacts.size(), kGrain, control, "two-point positioning", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 &n = contacts.n[i], &f = contacts.f[i];
            if (method.lean == Multipoint::Lean::separation) {
                poses[i] = widest(solver, contacts.face[i], contacts.uv[i], n, f, method.start);
                continue;
            }
            Vec3 lean = std::cos(method.yaw) * f + std::sin(method.yaw) * n.cross(f);
            if (method.lean == Multipoint::Lean::drop_axis) {
                const Vec3 up = method.drop_axis - method.drop_axis.dot(n) * n;
                constexpr double kLevel = 1e-6;  // on level ground the drop axis shows no direction: the feed does
                lean = up.norm() > kLevel ? up : f;
            }
            poses[i] = solver.at_contact(contacts.face[i], contacts.uv[i], lean, method.start);
        }
    });
    if (!done) return fail_up(std::move(done));
    Positioned all;
    for (std::size_t p = 0; p < contacts.passes.size(); ++p) {
        const ContactPass& pass = contacts.passes[p];
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            if (!poses[i])
                return tl::unexpected(std::move(poses[i].error()).in(fmt::format("contact {}", i)).in(fmt::format("pass {}", p)));
            add(all, *poses[i], contacts.f[i], contacts.given[i] != 0);
        }
        close_pass(all, pass.first, pass.closed);
    }
    return all;
}

/// The greatest tilts below the safe ones that change by at most `step` per pose: the lower envelope of cones, in two sweeps.
void limit_steps(Positioned& all, double step, double R_major, double R_minor) {
    for (const Pass& pass : all.cuts.passes) {
        std::vector<double> tilt;
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) tilt.push_back(all.poses[i].tilt);
        for (std::size_t k = 1; k < tilt.size(); ++k) tilt[k] = std::min(tilt[k], tilt[k - 1] + step);
        for (std::size_t k = tilt.size(); k-- > 1;) tilt[k - 1] = std::min(tilt[k - 1], tilt[k] + step);
        for (std::size_t k = 0; k < tilt.size(); ++k) {
            MultipointPose& pose = all.poses[pass.first + k];
            if (tilt[k] < pose.tilt) pose.turn_to(std::max(tilt[k], pose.tilt_minus), R_major, R_minor);
        }
    }
}

}  // namespace

std::vector<std::string_view> positioning_names() {
    return {Multipoint::name};
}

Result<Positioned> position(const Multipoint& method, const Pattern& pattern, const PathScene& scene, int refine,
                            const Control& control) {
    TRUNNION_REQUIRE(refine >= 1);
    MultipointOptions options;
    options.drop_axis = method.drop_axis;
    options.max_tilt = method.max_tilt;
    options.certificate = method.certificate;
    auto solver = MultipointSolver::build(scene.part, scene.faces, scene.cutter, options);
    if (!solver) return fail_up(std::move(solver));
    auto all = [&]() -> Result<Positioned> {
        if (const auto* parallel = std::get_if<Parallel>(&pattern)) {
            auto rows = rows_of(*parallel, method, scene, refine);
            if (!rows) return fail_up(std::move(rows));
            return drop_rows(*solver, *rows, control);
        }
        if (const auto* points = std::get_if<GivenPoints>(&pattern); points && !points->xy.empty())
            return drop_rows(*solver, rows_of(*points, method), control);
        auto contacts = plan_path(pattern, scene, control);
        if (!contacts) return fail_up(std::move(contacts));
        return raise_at(*solver, method, *contacts, control);
    }();
    if (!all) return all;
    if (method.max_step > 0.0) limit_steps(*all, method.max_step, solver->R_major(), solver->R_minor());
    for (std::size_t i = 0; i < all->poses.size(); ++i) {
        all->cuts.cl.push_back(all->poses[i].CL);
        all->cuts.axis.push_back(all->poses[i].T);
        all->cuts.contact.push_back(static_cast<std::int64_t>(i));
    }
    return all;
}

}  // namespace trunnion
