#include <algorithm>
#include <cmath>

#include "trunnion/base/parallel.hpp"
#include "trunnion/machine/timing.hpp"

namespace trunnion {

namespace {

/// A block whose tip moves less than this part of what its feed allows in the time of its rotary axes counts as a turn on the
/// spot.
constexpr double kRests = 1e-3;

const AxisLimits& limits_of(const Machine& machine, int j) {
    return j < 3 ? machine.linear[j].limits : machine.rotary[j - 3].limits;
}

/// Poses first .. last, from rest to rest.
struct Stretch {
    std::size_t first, last;
};

/// Second derivatives at the knots of the natural cubic splines through five rows of values. Thomas' algorithm.
std::vector<std::array<double, 5>> spline_moments(std::span<const double> s, std::span<const JointPosition> q) {
    const std::size_t n = s.size();
    std::vector<std::array<double, 5>> m(n, std::array<double, 5>{});
    std::vector<double> upper(n, 0.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double a = s[i] - s[i - 1], b = s[i + 1] - s[i];
        const double pivot = 2 * (a + b) - a * upper[i - 1];
        upper[i] = b / pivot;
        for (int j = 0; j < 5; ++j) {
            const double rise = (q[i + 1][j] - q[i][j]) / b - (q[i][j] - q[i - 1][j]) / a;
            m[i][j] = (6 * rise - a * m[i - 1][j]) / pivot;
        }
    }
    for (std::size_t i = n - 1; i-- > 1;)
        for (int j = 0; j < 5; ++j) m[i][j] -= upper[i] * m[i + 1][j];
    return m;
}

}  // namespace

Result<MotionTiming> time_motion(const MachinePath& path, const TimingOptions& options, const Control& control) {
    const PosePath& poses = path.poses();
    const Machine& machine = path.machine();
    const std::size_t n = poses.size();
    TRUNNION_REQUIRE(options.cells >= 2);
    MotionTiming timing;
    timing.time.assign(n, 0.0);
    timing.feed.assign(n, 0.0);
    timing.limit.assign(n, {});
    if (n == 0) return timing;
    std::array<AxisLimits, 5> limits;
    bool jerky = false;
    for (int j = 0; j < 5; ++j) {
        limits[j] = limits_of(machine, j);
        jerky = jerky || (options.jerk && limits[j].jerk > 0);
    }

    // Per block: feed, length of the tip's way, and the length it has as a path parameter.
    std::vector<double> feed(n, path.options().feed), chord(n, 0.0), length(n, 0.0);
    std::vector<std::uint8_t> rests(n, 0);
    for (const Pass& pass : poses.passes) {
        const bool lead = pass.kind == PassKind::lead_in || pass.kind == PassKind::lead_out;
        std::fill_n(feed.begin() + static_cast<std::ptrdiff_t>(pass.first), pass.count,
                    pass.rapid ? machine.rapid
                    : lead     ? path.options().lead_feed
                               : path.options().feed);
    }
    for (std::size_t i = 1; i < n; ++i) {
        chord[i] = (poses.cl[i] - poses.cl[i - 1]).norm();
        double seconds = 0.0;
        for (int j = 0; j < 5; ++j)
            seconds = std::max(seconds, std::abs(path.joints()[i][j] - path.joints()[i - 1][j]) / limits[j].velocity);
        rests[i] = chord[i] < kRests * feed[i] * seconds;
        length[i] = rests[i] ? feed[i] * seconds : chord[i];
    }
    // Stretches: a stop where the tip turns a corner, begins to rest, or does not move at all.
    std::vector<Stretch> stretches;
    std::size_t first = 0;
    const double cos_corner = std::cos(options.corner);
    for (std::size_t i = 1; i < n; ++i) {
        if (!(length[i] > 0)) {  // nothing moves
            if (i - 1 > first) stretches.push_back({first, i - 1});
            first = i;
            continue;
        }
        bool stop = i + 1 == n || rests[i] != rests[i + 1];
        if (!stop && !rests[i] && length[i + 1] > 0)
            stop = (poses.cl[i] - poses.cl[i - 1]).dot(poses.cl[i + 1] - poses.cl[i]) < cos_corner * chord[i] * chord[i + 1];
        if (!stop) continue;
        stretches.push_back({first, i});
        first = i;
    }
    timing.stops = stretches.size() + 1;

    std::vector<double> seconds(n, 0.0), least(stretches.size(), 0.0);
    std::vector<std::array<double, 16>> share(stretches.size(), std::array<double, 16>{});
    const auto run = [&](std::size_t k) -> Result<void> {
        const Stretch& stretch = stretches[k];
        const std::size_t blocks = stretch.last - stretch.first, cells = static_cast<std::size_t>(options.cells);
        std::vector<double> s(blocks + 1, 0.0);
        for (std::size_t b = 0; b < blocks; ++b) s[b + 1] = s[b] + length[stretch.first + b + 1];
        const auto q = std::span(path.joints()).subspan(stretch.first, blocks + 1);
        const auto m = spline_moments(s, q);
        std::vector<PathSample> samples(blocks * cells + 1);
        std::vector<double> step(blocks * cells);
        for (std::size_t b = 0; b < blocks; ++b) {
            const std::size_t pose = stretch.first + b + 1;
            // From the differences, so that a long way behind loses no digits.
            const double h = length[pose], inverse = 1.0 / h;
            for (std::size_t c = 0; c <= cells; ++c) {
                if (c == cells && b + 1 < blocks) break;
                PathSample& p = samples[b * cells + c];
                const double t = static_cast<double>(c) / static_cast<double>(cells);
                p.tip = rests[pose] ? 0.0 : 1.0;
                p.feed = c == 0 && b > 0 ? std::min(feed[pose], feed[pose - 1]) : feed[pose];
                for (int j = 0; j < 5; ++j) {
                    const double left = m[b][j], right = m[b + 1][j];
                    p.d1[j] = (q[b + 1][j] - q[b][j]) * inverse +
                              h * (left * (t - 0.5 * t * t - 1.0 / 3.0) + right * (0.5 * t * t - 1.0 / 6.0));
                    p.d2[j] = left + t * (right - left);
                    p.d3[j] = (right - left) * inverse;
                }
            }
            for (std::size_t c = 0; c < cells; ++c) step[b * cells + c] = h / static_cast<double>(cells);
        }
        SpeedProfile profile;
        if (jerky) {
            auto found = time_optimal_with_jerk(step, samples, limits, control);
            if (!found) return fail_up(std::move(found));
            profile = std::move(*found);
        } else {
            profile = time_optimal(step, samples, limits);
        }
        least[k] = profile.least_time;
        for (std::size_t b = 0; b < blocks; ++b) {
            double longest = 0.0;
            for (std::size_t c = b * cells; c < (b + 1) * cells; ++c) {
                const double spent = profile.seconds[c];
                seconds[stretch.first + b + 1] += spent;
                const ActiveLimit active = profile.limit[c];
                if (active.kind != LimitKind::none)
                    share[k][active.kind == LimitKind::feed ? 0 : 5 * static_cast<std::size_t>(active.kind) - 9 + active.axis] +=
                        spent;
                if (spent > longest) longest = spent, timing.limit[stretch.first + b + 1] = active;
            }
        }
        return {};
    };
    std::vector<std::uint8_t> failed(stretches.size(), 0);
    auto done = parallel_for(stretches.size(), 1, control, "timing", [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) failed[k] = !run(k);
    });
    if (!done) return fail_up(std::move(done));
    if (std::find(failed.begin(), failed.end(), 1) != failed.end()) return fail_cancelled("timing");

    for (std::size_t i = 1; i < n; ++i) {
        timing.time[i] = timing.time[i - 1] + seconds[i];
        if (seconds[i] > 0) timing.feed[i] = chord[i] / seconds[i];
    }
    timing.total = timing.time.back();
    for (std::size_t k = 0; k < stretches.size(); ++k) {
        timing.least += least[k];
        for (std::size_t l = 0; l < 16; ++l) timing.share[l] += share[k][l];
    }
    for (double& part : timing.share) part = timing.total > 0 ? part / timing.total : 0.0;
    return timing;
}

}  // namespace trunnion
