// Jerk limits: a sequence of convex programs in the squared speeds, each solved by a barrier method on a five-banded system.
#include <algorithm>
#include <cmath>
#include <vector>

#include "machine/motion_limits.hpp"
#include "trunnion/machine/timing.hpp"

namespace trunnion {

namespace {

/// Convex programs, each with the bound of the speed taken from the one before; the time falls by less than a percent after
/// these.
constexpr int kPrograms = 4;
/// Newton steps of one program; the barrier is then within kGap of the program's optimum.
constexpr int kMostNewton = 60;
constexpr double kGap = 1e-3;
constexpr double kSharpen = 8.0;
/// The start stands this far inside the limits.
constexpr double kStartInside = 0.5;

/// |c0 x[i-1] + c1 x[i] + c2 x[i+1]| <= 1 (limits divided out).
struct Row {
    double c[3];
};

class JerkProgram {
public:
    JerkProgram(std::span<const double> step, std::span<const PathSample> samples, const std::array<AxisLimits, 5>& limits)
        : h_(step), samples_(samples), limits_(limits), n_(samples.size()) {
        most_.assign(n_, 0.0);
        for (std::size_t i = 1; i + 1 < n_; ++i) {
            const PathSample& p = samples[i];
            double rate = p.tip / p.feed;
            for (int j = 0; j < 5; ++j) rate = std::max(rate, std::abs(p.d1[j]) / limits[j].velocity);
            most_[i] = 1.0 / std::max(1e-200, rate * rate);
        }
        for (int j = 0; j < 5; ++j)
            if (limits[j].jerk > 0) jerky_.push_back(j);
        // From rest to the first point and from the last one to rest at constant jerk: s = J t^3 / 6, so that x^1.5 = 4.5 J h^2.
        if (n_ > 2)
            for (const int j : jerky_) {
                const auto end = [&](std::size_t i, double h, double rate) {
                    if (std::abs(rate) > 1e-100)
                        most_[i] = std::min(most_[i], std::pow(4.5 * h * h * limits[j].jerk / std::abs(rate), 2.0 / 3.0));
                };
                end(1, h_[0], samples[0].d1[j]);
                end(n_ - 2, h_[n_ - 2], samples[n_ - 1].d1[j]);
            }
    }

    /// Makes x inside all limits the start; `bound` are squares that x will not pass.
    Result<std::vector<double>> solve(std::vector<double> x, const std::vector<double>& bound, const Control& control) {
        bound_ = bound;
        build();
        // Any profile, slowed down, is inside: all limits hold at rest.
        double used = 0.0;
        for (std::size_t i = 1; i + 1 < n_; ++i) used = std::max(used, x[i] / limit_of(i));
        for_rows([&](std::size_t i, const Row& row) { used = std::max(used, std::abs(value(row, x, i))); });
        const double scale = used > kStartInside ? kStartInside / used : 1.0;
        for (double& v : x) v *= scale;

        double rows = 0;
        for_rows([&](std::size_t, const Row&) { rows += 2; });
        rows += 2.0 * static_cast<double>(n_);
        double sharpness = rows / objective(x);
        std::vector<double> trial(n_);
        for (int k = 0; k < kMostNewton; ++k) {
            if (control.cancelled()) return fail_cancelled("timing under jerk limits");
            newton(x, sharpness);
            // The longest step that stays inside, then halved until the barrier falls.
            double length = 1.0;
            const auto at = [&](double t) {
                for (std::size_t i = 1; i + 1 < n_; ++i) trial[i] = x[i] + t * direction_[i];
                return barrier(trial, sharpness);
            };
            trial.front() = trial.back() = 0.0;
            const double before = barrier(x, sharpness);
            while (length > 1e-10 && !(at(length) <= before + 1e-4 * length * slope_)) length *= 0.5;
            if (length <= 1e-10) break;
            x = trial;
            if (-slope_ < 1.0) {
                if (rows / sharpness < kGap * objective(x)) break;
                sharpness *= kSharpen;
            }
        }
        return x;
    }

    double jerk_used(const std::vector<double>& x, std::size_t i, int j) const {
        return std::abs(value(jerk_row(i, j, x[i]), x, i));
    }
    const std::vector<int>& jerky() const { return jerky_; }

private:
    double limit_of(std::size_t i) const { return std::min(most_[i], bound_[i]); }
    double value(const Row& row, const std::vector<double>& x, std::size_t i) const {
        return row.c[0] * (i > 0 ? x[i - 1] : 0.0) + row.c[1] * x[i] + (i + 1 < n_ ? row.c[2] * x[i + 1] : 0.0);
    }
    /// At grid point i with the speed bounded by sqrt(square).
    Row jerk_row(std::size_t i, int j, double square) const {
        const double a = h_[i - 1], b = h_[i];
        const PathSample& p = samples_[i];
        // d3 may jump at i: the larger of both sides.
        const double d3 = std::abs(samples_[i - 1].d3[j]) > std::abs(p.d3[j]) ? samples_[i - 1].d3[j] : p.d3[j];
        const double speed = std::sqrt(square) / limits_[j].jerk;
        // u before = (x_i - x_(i-1)) / 2a, u after = (x_(i+1) - x_i) / 2b; mean and difference over (a + b)/2.
        const double mean = 3 * p.d2[j] * 0.5, rise = p.d1[j] * 2 / (a + b);
        const double after = mean + rise, before = mean - rise;
        return {{speed * -before / (2 * a), speed * (d3 + before / (2 * a) - after / (2 * b)), speed * after / (2 * b)}};
    }
    /// Both ends of the cell from i to i + 1, as a row about i.
    Row acceleration_row(std::size_t i, int j, bool at_end) const {
        const double h = h_[i], w = 1.0 / limits_[j].acceleration;
        const PathSample& p = samples_[at_end ? i + 1 : i];
        const double u = p.d1[j] / (2 * h);
        return {{0.0, w * (-u + (at_end ? 0.0 : p.d2[j])), w * (u + (at_end ? p.d2[j] : 0.0))}};
    }
    void build() {
        rows_.clear();
        first_.assign(n_ + 1, 0);
        for (std::size_t i = 0; i < n_; ++i) {
            first_[i] = rows_.size();
            if (i + 1 < n_)
                for (int j = 0; j < 5; ++j)
                    for (const bool end : {false, true}) rows_.push_back(acceleration_row(i, j, end));
            if (i > 0 && i + 1 < n_)
                for (const int j : jerky_) rows_.push_back(jerk_row(i, j, bound_[i]));
        }
        first_[n_] = rows_.size();
    }
    template <class Work>
    void for_rows(const Work& work) const {
        for (std::size_t i = 0; i < n_; ++i)
            for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) work(i, rows_[k]);
    }
    double weight(std::size_t i) const { return 0.5 * (h_[i - 1] + h_[i]); }
    /// Time, to the trapezoid rule.
    double objective(const std::vector<double>& x) const {
        double sum = 0.0;
        for (std::size_t i = 1; i + 1 < n_; ++i) sum += weight(i) / std::sqrt(x[i]);
        return sum;
    }
    double barrier(const std::vector<double>& x, double sharpness) const {
        double sum = 0.0;
        for (std::size_t i = 1; i + 1 < n_; ++i) {
            const double left = limit_of(i) - x[i];
            if (!(x[i] > 0 && left > 0)) return std::numeric_limits<double>::infinity();
            sum += sharpness * weight(i) / std::sqrt(x[i]) - std::log(left / limit_of(i));
        }
        for (std::size_t i = 0; i < n_; ++i) {
            // One logarithm of a product of a few rows.
            double product = 1.0;
            for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
                const double v = value(rows_[k], x, i), left = 1.0 - v * v;
                if (!(left > 0)) return std::numeric_limits<double>::infinity();
                product *= left;
                if (product < 1e-250) sum -= std::log(product), product = 1.0;
            }
            sum -= std::log(product);
        }
        return sum;
    }
    /// direction_ and slope_ at x: Hessian of five bands, factored as L D L'.
    void newton(const std::vector<double>& x, double sharpness) {
        gradient_.assign(n_, 0.0);
        band_.assign(n_, {0.0, 0.0, 0.0});
        for (std::size_t i = 1; i + 1 < n_; ++i) {
            const double root = std::sqrt(x[i]), left = limit_of(i) - x[i], w = sharpness * weight(i);
            gradient_[i] += -0.5 * w / (root * x[i]) + 1.0 / left;
            band_[i][0] += 0.75 * w / (root * x[i] * x[i]) + 1.0 / (left * left);
        }
        for_rows([&](std::size_t i, const Row& row) {
            const double v = value(row, x, i), left = 1.0 - v * v;
            const double g = 2 * v / left, curve = 2 * (1 + v * v) / (left * left);
            for (int a = 0; a < 3; ++a) {
                const std::size_t p = i + static_cast<std::size_t>(a) - 1;
                if (p == 0 || p >= n_ - 1) continue;
                gradient_[p] += g * row.c[a];
                for (int b = 0; b <= a; ++b) {
                    const std::size_t q = i + static_cast<std::size_t>(b) - 1;
                    if (q == 0 || q >= n_ - 1) continue;
                    band_[p][static_cast<std::size_t>(a - b)] += curve * row.c[a] * row.c[b];
                }
            }
        });
        // band_[i][k] is the entry (i, i - k).
        direction_.assign(n_, 0.0);
        for (std::size_t i = 1; i + 1 < n_; ++i) {
            const double d2 = i > 2 ? band_[i - 2][0] : 1.0, d1 = i > 1 ? band_[i - 1][0] : 1.0;
            const double l2 = i > 2 ? band_[i][2] / d2 : 0.0;
            const double l1 = i > 1 ? (band_[i][1] - l2 * d2 * (i > 2 ? band_[i - 1][1] : 0.0)) / d1 : 0.0;
            band_[i][0] -= l1 * l1 * d1 + l2 * l2 * d2;
            band_[i][1] = l1;
            band_[i][2] = l2;
            direction_[i] = -gradient_[i] - l1 * direction_[i - 1] - l2 * (i > 1 ? direction_[i - 2] : 0.0);
        }
        for (std::size_t i = 1; i + 1 < n_; ++i) direction_[i] /= band_[i][0];
        for (std::size_t i = n_ - 1; i-- > 1;) {
            if (i + 1 < n_ - 1) direction_[i] -= band_[i + 1][1] * direction_[i + 1];
            if (i + 2 < n_ - 1) direction_[i] -= band_[i + 2][2] * direction_[i + 2];
        }
        slope_ = 0.0;
        for (std::size_t i = 1; i + 1 < n_; ++i) slope_ += gradient_[i] * direction_[i];
    }

    std::span<const double> h_;
    std::span<const PathSample> samples_;
    std::array<AxisLimits, 5> limits_;
    std::size_t n_;
    std::vector<double> most_, bound_, gradient_, direction_;
    std::vector<int> jerky_;
    std::vector<Row> rows_;
    std::vector<std::size_t> first_;
    std::vector<std::array<double, 3>> band_;
    double slope_ = 0.0;
};

}  // namespace

Result<SpeedProfile> time_optimal_with_jerk(std::span<const double> step, std::span<const PathSample> samples,
                                            const std::array<AxisLimits, 5>& limits, const Control& control) {
    SpeedProfile profile = time_optimal(step, samples, limits);
    JerkProgram program(step, samples, limits);
    const std::size_t n = samples.size();
    if (program.jerky().empty()) return profile;
    std::vector<double> bound = profile.square, x = profile.square;
    for (int k = 0; k < kPrograms; ++k) {
        auto better = program.solve(x, bound, control);
        if (!better) return fail_up(std::move(better));
        x = std::move(*better);
        // A point may go faster in the next program as long as its bound is right for it.
        for (std::size_t i = 0; i < n; ++i) bound[i] = std::min(profile.square[i], 1.2 * x[i]);
    }
    profile.square = x;
    profile.time = 0.0;
    for (std::size_t i = 0; i + 1 < n; ++i) {
        // Constant acceleration; at the ends it grows from nothing, which costs half the time that this takes, or half of the
        // cell's where it takes all of it (s = J t^3 / 6).
        profile.seconds[i] = 2 * step[i] / (std::sqrt(x[i]) + std::sqrt(x[i + 1]));
        if (i == 0 || i + 2 == n) {
            double growth = 0.0;
            for (const int j : program.jerky())
                growth = std::max(growth, std::max(x[i], x[i + 1]) * std::abs(samples[i == 0 ? 0 : n - 1].d1[j]) /
                                              (4 * step[i] * limits[j].jerk));
            profile.seconds[i] += std::min(growth, 0.5 * profile.seconds[i]);
        }
        profile.time += profile.seconds[i];
    }
    detail::fill_limits(profile, step, samples, limits);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        double most = 0.0;
        ActiveLimit jerk;
        for (const std::size_t k : {i, i + 1})
            if (k > 0 && k + 1 < n)
                for (const int j : program.jerky()) {
                    const double used = program.jerk_used(x, k, j);
                    if (used > most) most = used, jerk = {LimitKind::jerk, static_cast<std::uint8_t>(j)};
                }
        // The barrier stops a little inside every limit; what is used for more than nine tenths counts.
        if (most > 0.9) profile.limit[i] = jerk;
    }
    return profile;
}

}  // namespace trunnion
