#include "trunnion/check/deviation.hpp"

#include <unordered_map>

#include <fmt/format.h>

#include "check/piece_bound.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace {

constexpr std::size_t kGrain = 256;

/// Poses by the cube their cutter's bounding ball is centred in.
class PoseGrid {
public:
    PoseGrid(const PosePath& path, const Profile& profile, double cap)
        : reach_(std::hypot(profile.radius_max(), 0.5 * (profile.height_hi() - profile.height_lo())) + cap),
          middle_(0.5 * (profile.height_hi() + profile.height_lo())) {
        for (const Pass& pass : path.passes) {
            if (pass.kind != PassKind::cut) continue;
            for (std::size_t i = pass.first; i < pass.first + pass.count; ++i)
                cubes_[key(cube(path.cl[i] + middle_ * path.axis[i]))].push_back(static_cast<std::uint32_t>(i));
        }
    }

    /// Calls visit(pose) for every pose whose cutter may be within the cap of x, in a fixed order.
    template <class Visit>
    void near(const Vec3& x, const Visit& visit) const {
        const Cube c = cube(x);
        for (std::int64_t i = -1; i <= 1; ++i)
            for (std::int64_t j = -1; j <= 1; ++j)
                for (std::int64_t k = -1; k <= 1; ++k) {
                    const auto at = cubes_.find(key({c.x + i, c.y + j, c.z + k}));
                    if (at == cubes_.end()) continue;
                    for (const std::uint32_t pose : at->second) visit(pose);
                }
    }
    double reach() const { return reach_; }
    double middle() const { return middle_; }

private:
    struct Cube {
        std::int64_t x, y, z;
    };
    Cube cube(const Vec3& x) const {
        const auto index = [&](double v) { return static_cast<std::int64_t>(std::floor(v / reach_)); };
        return {index(x.x()), index(x.y()), index(x.z())};
    }
    /// 21 bits each: two cubes with one key only mean a few poses looked at for nothing.
    static std::uint64_t key(const Cube& c) {
        constexpr std::uint64_t kMask = (1u << 21) - 1;
        return (static_cast<std::uint64_t>(c.x) & kMask) << 42 | (static_cast<std::uint64_t>(c.y) & kMask) << 21 |
               (static_cast<std::uint64_t>(c.z) & kMask);
    }

    double reach_, middle_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cubes_;
};

/// Least t in [-cap, most] at which x + t n is in the cutter; `most` if there is none. The signed distance is convex along the
/// ray, so Newton's iteration from outside runs to the first crossing without passing it.
double entry(const Profile& profile, const ToolFrame& frame, const Vec3& x, const Vec3& n, double cap, double most) {
    const Vec3 X = frame.point(x), N = frame.to_tool * n;
    double t = -cap;
    constexpr int kSteps = 60;
    for (int i = 0; i < kSteps; ++i) {
        const Sample s = sample(profile, X + t * N);
        if (s.f <= 0.0) return t;
        const double slope = s.g.dot(N);
        if (slope >= 0.0) return most;
        const double step = -s.f / slope;
        if (t + step >= most) return most;
        constexpr double kSettled = 1e-12;  // mm
        if (step <= kSettled) return t;
        t += step;
    }
    return t;
}

}  // namespace

Result<DeviationMap> deviation_map(const PosePath& path, const Cutter& cutter, std::span<const Vec3> points,
                                   std::span<const Vec3> normals, double cap, const Control& control) {
    if (points.size() != normals.size())
        return fail(ErrorCode::invalid_input, fmt::format("{} points but {} normals", points.size(), normals.size()));
    if (!(cap > 0.0)) return fail(ErrorCode::invalid_input, fmt::format("a cap of {:.6g} mm must be positive", cap));
    const ToolPiece& piece = cutter.pieces().front();
    if (!piece.profile.convex_in_space())
        return fail(ErrorCode::unsupported, "the deviation map of a cutter with an open bottom is not known");
    const PoseGrid grid(path, piece.profile, cap);
    std::vector<std::uint8_t> cut(path.size(), 0);  // the motion that leads here is part of a cut
    for (const Pass& pass : path.passes)
        if (pass.kind == PassKind::cut)
            for (std::size_t i = pass.first + 1; i < pass.first + pass.count; ++i) cut[i] = 1;

    DeviationMap map;
    map.deviation.assign(points.size(), std::numeric_limits<double>::quiet_NaN());
    map.pose.assign(points.size(), -1);
    auto done = parallel_for(points.size(), kGrain, control, "deviation", [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const Vec3 &x = points[k], &n = normals[k];
            double best = cap;
            std::int64_t nearest = -1;
            grid.near(x, [&](std::uint32_t i) {
                if ((path.cl[i] + grid.middle() * path.axis[i] - x).squaredNorm() > grid.reach() * grid.reach()) return;
                const double t = entry(piece.profile, ToolFrame::at(path.cl[i], path.axis[i]), x, n, cap, best);
                if (t < best) best = t, nearest = i;
            });
            if (nearest < 0) continue;
            const auto i = static_cast<std::size_t>(nearest);
            // Between poses the cutter comes lower still: golden section on the motions to and from the closest.
            const auto motion = [&](std::size_t a) {
                const auto at = [&](double s) {
                    const Vec3 tip = path.cl[a] + s * (path.cl[a + 1] - path.cl[a]);
                    return entry(piece.profile, ToolFrame::at(tip, slerp(path.axis[a], path.axis[a + 1], s)), x, n, cap, cap);
                };
                constexpr double kGolden = 0.6180339887498949;
                double lo = 0.0, hi = 1.0, p = hi - kGolden, q = kGolden, fp = at(p), fq = at(q);
                constexpr int kSteps = 24;  // to 1e-5 of a step, whose square is what the height is off by
                for (int step = 0; step < kSteps; ++step) {
                    if (fp <= fq) {
                        hi = q, q = p, fq = fp;
                        p = hi - kGolden * (hi - lo), fp = at(p);
                    } else {
                        lo = p, p = q, fp = fq;
                        q = lo + kGolden * (hi - lo), fq = at(q);
                    }
                }
                best = std::min({best, fp, fq});
            };
            if (cut[i]) motion(i - 1);
            if (i + 1 < path.size() && cut[i + 1]) motion(i);
            map.deviation[k] = best;
            map.pose[k] = nearest;
        }
    });
    if (!done) return fail_up(std::move(done));
    return map;
}

}  // namespace trunnion
