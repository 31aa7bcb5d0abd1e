// The best fixed axis over the whole sphere, and the proof of how good it is (fixed-axis sheet, section 12).
#include <algorithm>
#include <numeric>
#include <queue>

#include <fmt/format.h>

#include "orientation/fixed_quadratic.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/orientation/axis_set.hpp"

namespace trunnion {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Even directions of the hemisphere about `pole`.
std::vector<Vec3> fibonacci(const Vec3& pole, int count) {
    const Vec3 x = any_perpendicular(pole), y = pole.cross(x);
    const double golden = kPi * (3.0 - std::sqrt(5.0));
    std::vector<Vec3> all(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (i + 0.5) / count, across = std::sqrt(1.0 - z * z), a = golden * i;
        all[static_cast<std::size_t>(i)] = (z * pole + across * (std::cos(a) * x + std::sin(a) * y)).normalized();
    }
    return all;
}

class Finder {
public:
    Finder(const FixedProblem& problem, const std::function<bool(const Vec3&)>& clear) : problem_(problem), clear_(clear) {}

    /// Takes the axis if it is better and allowed; cheap questions first.
    bool offer(const Vec3& axis, FixedBest& best) const {
        const double n = passes_needed(problem_, axis);
        if (!(n < best.passes) || !passes_within_margins(problem_, axis)) return false;
        if (clear_ && !clear_(axis)) return false;
        best.axis = axis;
        best.passes = n;
        return true;
    }

    /// Pattern search on the sphere. The optimum often lies where two margins meet, which few directions lead into: many are
    /// tried, turned each round by an angle that never repeats.
    void polish(FixedBest& best, const Control& control) const {
        constexpr int kDirections = 16;
        double turn = 0.0;
        const double kFinest = radians(0.004);
        for (double step = radians(2.0); step > kFinest && !control.cancelled();) {
            const Vec3 x = any_perpendicular(best.axis), y = best.axis.cross(x), from = best.axis;
            bool better = false;
            for (int k = 0; k < kDirections; ++k) {
                const double a = turn + 2.0 * kPi * k / kDirections;
                const Vec3 way = std::cos(a) * x + std::sin(a) * y;
                better |= offer((std::cos(step) * from + std::sin(step) * way).normalized(), best);
            }
            turn += 1.0;
            if (!better) step *= 0.6;
        }
    }

    /// The best of even directions, 8 deg apart, each polished.
    Result<void> sample(const FixedSearch& options, FixedBest& best, const Control& control) const {
        const std::vector<Vec3> all = fibonacci(problem_.mean_normal(), options.directions);
        std::vector<double> n(all.size());
        auto done = parallel_for(all.size(), 64, control, "tool axes", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) n[i] = passes_needed(problem_, all[i]);
        });
        if (!done) return done;
        std::vector<std::size_t> order(all.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return n[a] < n[b]; });
        constexpr std::size_t kSeeds = 6;
        const double cos_apart = std::cos(radians(8.0));
        std::vector<Vec3> seeds;
        for (const std::size_t i : order) {
            if (seeds.size() == kSeeds || !std::isfinite(n[i])) break;
            if (control.cancelled()) return fail_cancelled("the search for a tool axis");
            if (std::any_of(seeds.begin(), seeds.end(), [&](const Vec3& s) { return s.dot(all[i]) > cos_apart; })) continue;
            FixedBest seed;
            seed.passes = kInfinity;
            if (!offer(all[i], seed)) continue;
            seeds.push_back(all[i]);
            polish(seed, control);
            if (seed.passes < best.passes) best = seed;
        }
        return {};
    }

private:
    const FixedProblem& problem_;
    const std::function<bool(const Vec3&)>& clear_;
};

/// Least and greatest of a sinusoid over an interval of twice the yaw about (cos2, sin2), of half-width known by its cosine and
/// sine; `whole`: over all yaws.
struct Extremes {
    double least, greatest;
};
Extremes extremes(const Sinusoid& f, double cos2, double sin2, double half_cos, double half_sin, bool whole) {
    const double amplitude = std::hypot(f.c, f.s);
    if (whole) return {f.constant - amplitude, f.constant + amplitude};
    const double x = f.c * cos2 + f.s * sin2, y = f.s * cos2 - f.c * sin2;  // amplitude cos, sin of the angle to the crest
    const double edge = std::abs(y) * half_sin, near = x * half_cos;
    return {f.constant + (-x >= amplitude * half_cos ? -amplitude : near - edge),
            f.constant + (x >= amplitude * half_cos ? amplitude : near + edge)};
}

/// What holds for every axis of a cap about `centre` (sheet, section 12).
class CapBound {
public:
    CapBound(const FixedProblem& problem, const Vec3& centre, double radius)
        : problem_(problem), centre_(centre), cos_(std::cos(radius)), sin_(std::sin(radius)) {
        const FixedMargins& m = problem.margins;
        cos_most_ = std::cos(m.greatest_inclination);
        cos_least_ = problem.tool.R_major > 0.0 ? std::cos(m.least_inclination) : 1.0;
        sin_least_ = problem.tool.R_major > 0.0 ? std::sin(m.least_inclination) : 0.0;
    }

    /// At least 1/(Q^-1)_22 for every axis of the cap that keeps the margins; nothing if none does, here.
    std::optional<double> stiffness(const FixedPatch::Sample& s) const {
        const FixedTool& tool = problem_.tool;
        const double K = problem_.margins.least_curvature;
        const FixedLean lean(s, centre_, tool);
        // Inclination within [a - rho, a + rho].
        const bool pole = lean.cosine >= cos_, antipode = lean.cosine <= -cos_;
        const double cos_lo = pole ? 1.0 : lean.cosine * cos_ + lean.sine * sin_;       // of the least inclination
        const double cos_hi = antipode ? -1.0 : lean.cosine * cos_ - lean.sine * sin_;  // of the greatest
        constexpr double kRounding = 1e-12;  // a cap that only touches a margin is kept
        if (cos_lo < cos_most_ - kRounding || cos_hi > cos_least_ + kRounding) return std::nullopt;
        // The parallel's curvature grows with the inclination: least and greatest within the margins.
        const double sin_lo = cos_lo >= cos_least_ ? sin_least_ : std::sqrt(std::max(0.0, 1.0 - cos_lo * cos_lo));
        const double sin_hi = cos_hi <= 0.0 ? 1.0 : std::sqrt(std::max(0.0, 1.0 - cos_hi * cos_hi));
        // Yaw within asin(sin rho / sin a): twice that is what the sinusoids see.
        const bool round = !(lean.sine > sin_ * 1.0000001) || lean.cosine * lean.cosine >= cos_ * cos_;
        const double ratio = round ? 1.0 : sin_ / lean.sine;
        const double half_cos = 1.0 - 2.0 * ratio * ratio, half_sin = 2.0 * ratio * std::sqrt(std::max(0.0, 1.0 - ratio * ratio));
        const bool whole = round;

        const double kp_lo = FixedLean::parallel_curvature(std::max(sin_lo, kParallelSine), tool),
                     kp_hi = FixedLean::parallel_curvature(std::max(sin_hi, kParallelSine), tool);
        // Q grows with kp. If Q - K is indefinite even at the greatest kp for every yaw, no axis keeps the margin.
        const TangentForm margin{s.form.q11 + K, s.form.q12, s.form.q22 + K};
        if (extremes(det_of(margin, kp_hi, tool.r), lean.cos2, lean.sin2, half_cos, half_sin, whole).greatest < -kRounding)
            return std::nullopt;
        // And (Q^-1)_22 is greatest at the least kp; bounded apart there. 1/(Q^-1)_22 >= lambda_min(Q) >= K anyhow.
        const double det = extremes(det_of(s.form, kp_lo, tool.r), lean.cos2, lean.sin2, half_cos, half_sin, whole).least;
        const double q11 = extremes(q11_of(s.form, kp_lo, tool.r), lean.cos2, lean.sin2, half_cos, half_sin, whole).greatest;
        if (!(det > 0.0)) return K;
        if (!(q11 > 0.0)) return std::nullopt;
        return std::max(K, det / q11);
    }

    /// At least N over the cap; infinite where no axis of it keeps the margins.
    double passes() const {
        double sum = 0.0;
        for (const FixedPatch& patch : problem_.patches) {
            const auto rows = patch.row_end().size();
            std::size_t i = 0;
            for (std::size_t row = 0; row < rows; ++row) {
                double most = 0.0;
                for (; i < patch.row_end()[row]; ++i) {
                    const FixedPatch::Sample& s = patch.samples()[i];
                    const auto k = stiffness(s);
                    if (!k) return kInfinity;
                    most = std::max(most, *k * s.across * s.across);
                }
                sum += std::sqrt(most / (8.0 * problem_.tool.scallop)) / static_cast<double>(rows);
            }
        }
        constexpr double kRounding = 1e-12;  // of a few hundred sums and quotients, relative
        return sum * (1.0 - kRounding);
    }

private:
    const FixedProblem& problem_;
    Vec3 centre_;
    double cos_, sin_;
    double cos_most_, cos_least_, sin_least_;
};

}  // namespace

Result<FixedBest> find_fixed_axis(const FixedProblem& problem, const std::function<bool(const Vec3&)>& clear,
                                  const FixedSearch& options, const Control& control) {
    const Finder finder(problem, clear);
    FixedBest best;
    best.passes = kInfinity;
    if (auto done = finder.sample(options, best, control); !done) return fail_up(std::move(done));

    // Branch and bound, the most promising cell first.
    struct Entry {
        double bound;
        AxisCell cell;
        bool operator<(const Entry& other) const {
            if (bound != other.bound) return bound > other.bound;
            return cell.level != other.cell.level ? cell.level > other.cell.level : cell.index > other.cell.index;
        }
    };
    std::priority_queue<Entry> open;
    // The axis must stand less than 90 deg from every normal: half of the sphere falls at once.
    for (std::uint32_t face = 0; face < 6; ++face) open.push({0.0, AxisCell{0, face}});
    constexpr int kDeepest = 13;  // 4^13 cells a face still fit their index; cells are 1e-4 rad then
    std::size_t cells = 0;
    double settled = kInfinity;  // least bound of cells that are not split further
    while (!open.empty() && cells < options.cells) {
        if (open.top().bound >= (1.0 - options.gap) * best.passes) break;
        if (control.cancelled()) return fail_cancelled("the search for a tool axis");
        const Entry entry = open.top();
        open.pop();
        if (entry.cell.level == kDeepest) {
            settled = std::min(settled, entry.bound);
            continue;
        }
        for (std::uint32_t k = 0; k < 4; ++k) {
            const AxisCell child = entry.cell.child(k);
            const Vec3 centre = child.centre();
            const double bound = std::max(entry.bound, CapBound(problem, centre, child.radius()).passes());
            ++cells;
            if (bound >= best.passes) continue;
            constexpr int kWorthwhile = 4;
            if (child.level >= kWorthwhile && finder.offer(centre, best)) finder.polish(best, control);
            open.push({bound, child});
        }
    }
    if (!std::isfinite(best.passes)) {
        if (open.empty() && !std::isfinite(settled))
            return fail(ErrorCode::no_solution,
                        fmt::format("no fixed axis: for every axis some point is inclined outside {:.4g} to {:.4g} deg or the "
                                    "cutter (R_major {:.6g}, r {:.6g} mm) is too flat for it; use a smaller cutter or split the "
                                    "patch (proved on {} cells)",
                                    degrees(problem.margins.least_inclination), degrees(problem.margins.greatest_inclination),
                                    problem.tool.R_major, problem.tool.r, cells));
        return fail(ErrorCode::no_solution,
                    fmt::format("no fixed axis found in {} directions and {} cells that keeps the margins and is clear of part, "
                                "holder and travel everywhere; split the patch or use a slimmer or longer tool",
                                options.directions, cells));
    }
    best.cells = cells;
    best.lower_bound = std::min({best.passes, settled, open.empty() ? best.passes : open.top().bound});
    return best;
}

}  // namespace trunnion
