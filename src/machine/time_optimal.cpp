#include <algorithm>
#include <cmath>
#include <limits>

#include "machine/motion_limits.hpp"
#include "trunnion/machine/timing.hpp"

namespace trunnion {

namespace detail {

namespace {

/// Squares and accelerations beyond this mean no limit at all (mm, s); its square is still a double.
constexpr double kUnlimited = 1e100;
/// A square is kept this much (relative) inside the border of its interval, many ulp, so that rounding in the pass forward cannot
/// leave it empty; over 1e5 cells the speed loses 1e-8.
constexpr double kInside = 1.0 - 1e-13;
/// Newton's method on a concave function of 22 lines meets each line once at most.
constexpr int kMostSteps = 40;
constexpr int kRows = 12;

/// Rows of |u + m x| bounded: -lo <= u + m x <= hi, for the cell's acceleration u = s'' and the square x at its start.
struct Cell {
    alignas(64) double m[kRows], lo[kRows], hi[kRows];
    double most = kUnlimited;  // bound of x

    void set(int row, double a, double b) {
        // |a u + b x| <= 1. Where a vanishes only x is bounded.
        const double size = std::abs(a);
        if (size < 1.0 / kUnlimited) {
            m[row] = 0.0;
            lo[row] = hi[row] = kUnlimited;
            if (std::abs(b) > 0) most = std::min(most, 1.0 / std::abs(b));
            return;
        }
        const double inverse = 1.0 / a;
        m[row] = b * inverse;
        lo[row] = hi[row] = std::abs(inverse);
    }
    double greatest(double x, int& row) const {
        double best = std::numeric_limits<double>::infinity();
        for (int k = 0; k < kRows; ++k) {
            const double value = hi[k] - m[k] * x;
            if (value < best) best = value, row = k;
        }
        return best;
    }
    double least(double x, int& row) const {
        double best = -std::numeric_limits<double>::infinity();
        for (int k = 0; k < kRows; ++k) {
            const double value = -lo[k] - m[k] * x;
            if (value > best) best = value, row = k;
        }
        return best;
    }
    /// The greatest x for which some u is left. The width of the interval of u is concave in x and not negative at 0, so Newton's
    /// method from the right never passes the root.
    double greatest_square() const {
        double x = most;
        for (int step = 0; step < kMostSteps; ++step) {
            int up = 0, down = 0;
            const double width = greatest(x, up) - least(x, down);
            if (width >= 0) break;
            const double next = (hi[up] + lo[down]) / (m[up] - m[down]);
            if (!(next < x)) break;  // at the root, to rounding
            x = std::max(0.0, next);
        }
        return x;
    }
};

/// The path as the passes need it, forwards or from its end.
class Passes {
public:
    Passes(std::span<const double> step, std::span<const PathSample> samples, const std::array<AxisLimits, 5>& limits)
        : step_(step), samples_(samples) {
        for (int j = 0; j < 5; ++j) {
            velocity_[j] = limits[j].velocity;
            inverse_[j] = 1.0 / limits[j].acceleration;
        }
    }

    /// Bound of the square by velocities and feed at a grid point.
    double fastest(std::size_t i) const {
        const PathSample& p = samples_[i];
        double rate = p.tip / p.feed;
        for (int j = 0; j < 5; ++j) rate = std::max(rate, std::abs(p.d1[j]) / velocity_[j]);
        return rate * rate > 1.0 / kUnlimited ? 1.0 / (rate * rate) : kUnlimited;
    }
    /// The cell from grid point i to the next in the direction of travel (+1 or -1), which may hold at most `after` at its end.
    Cell cell(std::size_t i, int direction, double after) const {
        const std::size_t end = direction > 0 ? i + 1 : i - 1;
        const double h = step_[std::min(i, end)];
        const PathSample &p = samples_[i], &q = samples_[end];
        Cell c;
        c.most = fastest(i);
        for (int j = 0; j < 5; ++j) {
            // Travelled backwards, first derivatives change their sign.
            const double w = inverse_[j], d = direction * w;
            c.set(j, d * p.d1[j], w * p.d2[j]);
            // At the end of the cell the square is x + 2 h u.
            c.set(5 + j, d * q.d1[j] + 2 * h * w * q.d2[j], w * q.d2[j]);
        }
        // 0 <= x + 2 h u <= after
        c.m[10] = 0.5 / h;
        c.lo[10] = 0.0;
        c.hi[10] = after * c.m[10];
        c.m[11] = 0.0;
        c.lo[11] = c.hi[11] = kUnlimited;
        return c;
    }

private:
    std::span<const double> step_;
    std::span<const PathSample> samples_;
    std::array<double, 5> velocity_{}, inverse_{};
};

double duration(std::span<const double> step, std::span<const double> square) {
    double time = 0.0;
    for (std::size_t i = 0; i + 1 < square.size(); ++i) {
        const double sum = std::sqrt(square[i]) + std::sqrt(square[i + 1]);
        time += 2 * step[i] / sum;
    }
    return time;
}

}  // namespace

void fill_limits(SpeedProfile& profile, std::span<const double> step, std::span<const PathSample> samples,
                 const std::array<AxisLimits, 5>& limits) {
    const std::size_t n = samples.size();
    profile.limit.assign(n - 1, {});
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const double u = (profile.square[i + 1] - profile.square[i]) / (2 * step[i]);
        double most = 0.0;
        ActiveLimit& active = profile.limit[i];
        const auto weigh = [&](double used, LimitKind kind, int axis) {
            if (used > most) most = used, active = {kind, static_cast<std::uint8_t>(axis)};
        };
        for (const std::size_t k : {i, i + 1}) {
            const PathSample& p = samples[k];
            const double x = profile.square[k], speed = std::sqrt(x);
            weigh(speed * p.tip / p.feed, LimitKind::feed, 0);
            for (int j = 0; j < 5; ++j) {
                weigh(speed * std::abs(p.d1[j]) / limits[j].velocity, LimitKind::velocity, j);
                weigh(std::abs(p.d2[j] * x + p.d1[j] * u) / limits[j].acceleration, LimitKind::acceleration, j);
            }
        }
    }
}

}  // namespace detail

SpeedProfile time_optimal(std::span<const double> step, std::span<const PathSample> samples,
                          const std::array<AxisLimits, 5>& limits) {
    TRUNNION_REQUIRE(samples.size() >= 3 && step.size() + 1 == samples.size());
    const std::size_t n = samples.size();
    const detail::Passes passes(step, samples, limits);
    SpeedProfile profile;
    profile.square.assign(n, 0.0);

    // From the start: what can be reached at all, coming from rest; no faster than at the end of the cell may be.
    std::vector<double> reachable(n, 0.0), controllable(n, 0.0);
    for (std::size_t i = 1; i < n; ++i) reachable[i] = passes.cell(i, -1, reachable[i - 1]).greatest_square() * detail::kInside;
    // From the end: the greatest square from which the rest can be followed to a standstill.
    for (std::size_t i = n - 1; i-- > 0;)
        controllable[i] = passes.cell(i, +1, controllable[i + 1]).greatest_square() * detail::kInside;
    controllable[0] = 0.0;  // at rest

    // Forwards, as fast as it goes.
    std::vector<double>& x = profile.square;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        int row = 0;
        const double u = passes.cell(i, +1, controllable[i + 1]).greatest(x[i], row);
        x[i + 1] = std::clamp(x[i] + 2 * step[i] * u, 0.0, controllable[i + 1]);
    }
    profile.seconds.resize(n - 1);
    for (std::size_t i = 0; i + 1 < n; ++i) profile.seconds[i] = 2 * step[i] / (std::sqrt(x[i]) + std::sqrt(x[i + 1]));
    profile.time = detail::duration(step, x);
    for (std::size_t i = 0; i < n; ++i) reachable[i] = std::min(reachable[i], controllable[i]);
    reachable[0] = reachable[n - 1] = 0.0;
    profile.least_time = std::min(profile.time, detail::duration(step, reachable));  // equal but for rounding where tight
    detail::fill_limits(profile, step, samples, limits);
    return profile;
}

std::string name_of(const ActiveLimit& limit, const Machine& machine) {
    const char letter = limit.axis < 3 ? machine.linear[limit.axis].letter : machine.rotary[limit.axis - 3].letter;
    switch (limit.kind) {
        case LimitKind::feed:
            return "feed";
        case LimitKind::velocity:
            return std::string("velocity of ") + letter;
        case LimitKind::acceleration:
            return std::string("acceleration of ") + letter;
        case LimitKind::jerk:
            return std::string("jerk of ") + letter;
        default:
            return "nothing";
    }
}

}  // namespace trunnion
