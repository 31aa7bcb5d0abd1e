#include "path/sampling.hpp"

#include <algorithm>

namespace trunnion {

namespace {

constexpr int kProbes = 128;              // first look at a curve
constexpr int kRounds = 12;               // each raises the density where a limit is broken
constexpr std::size_t kMost = 4'000'000;  // contacts of one pass: a wrong unit, not a wish

std::vector<double> linspace(const Interval& range, int pieces) {
    std::vector<double> t(static_cast<std::size_t>(pieces) + 1);
    for (int i = 0; i <= pieces; ++i)
        t[static_cast<std::size_t>(i)] = i == pieces ? range.hi : range.at(static_cast<double>(i) / pieces);
    return t;
}

/// The grid with the middle of every step between: entry 2 i is grid[i].
std::vector<double> with_middles(const std::vector<double>& grid) {
    std::vector<double> probe;
    for (std::size_t i = 0; i + 1 < grid.size(); ++i) {
        probe.push_back(grid[i]);
        probe.push_back(0.5 * (grid[i] + grid[i + 1]));
    }
    probe.push_back(grid.back());
    return probe;
}

double distance_to_chord(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 e = b - a;
    const double length2 = e.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(e) / length2, 0.0, 1.0) : 0.0;
    return (p - a - t * e).norm();
}

}  // namespace

double step_excess(const CurvePoint& a, const CurvePoint& m, const CurvePoint& b, const SampleLimits& limits) {
    double worst = 0.0;
    const double sagitta = distance_to_chord(m.p, a.p, b.p);
    worst = std::sqrt(sagitta / limits.chord);
    if (a.regular && m.regular && b.regular) {
        const double off = distance_to_chord(m.p + limits.offset * m.n, a.p + limits.offset * a.n, b.p + limits.offset * b.n);
        worst = std::max(worst, std::sqrt(off / limits.chord));
        worst = std::max(worst, (angle_between(a.n, m.n) + angle_between(m.n, b.n)) / limits.angle);
    }
    if (limits.step > 0.0) worst = std::max(worst, (b.p - a.p).norm() / limits.step);
    return worst;
}

std::vector<double> sample_curve(const Curve& curve, const Interval& range, const SampleLimits& limits) {
    // Density (steps per unit of t) on a grid of cells, piecewise constant; each round measures it on finer steps.
    std::vector<double> grid = linspace(range, kProbes);
    std::vector<double> times;
    for (int round = 0; round < kRounds; ++round) {
        const std::vector<double> probe = with_middles(grid);
        const std::vector<CurvePoint> p = curve(probe);
        std::vector<double> wanted(grid.size() - 1);  // steps this cell should be cut into
        double worst = 0.0;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            wanted[i] = step_excess(p[2 * i], p[2 * i + 1], p[2 * i + 2], limits);
            worst = std::max(worst, wanted[i]);
        }
        if (round > 0 && worst <= 1.0) return grid;
        // Neighbouring spacings may differ by a quarter at the most: an even feed is easier on the machine.
        for (std::size_t i = 1; i < wanted.size(); ++i) wanted[i] = std::max(wanted[i], wanted[i - 1] / 1.25);
        for (std::size_t i = wanted.size(); i-- > 1;) wanted[i - 1] = std::max(wanted[i - 1], wanted[i] / 1.25);
        double total = 0.0;
        std::vector<double> sum{0.0};
        for (const double w : wanted) sum.push_back(total += std::max(w, 1e-6) * (round > 0 ? 1.02 : 1.0));
        const auto steps = static_cast<std::size_t>(std::clamp(std::ceil(total), 1.0, static_cast<double>(kMost)));
        std::vector<double> next{range.lo};
        std::size_t cell = 0;
        for (std::size_t k = 1; k < steps; ++k) {
            const double level = total * static_cast<double>(k) / static_cast<double>(steps);
            while (cell + 1 < wanted.size() && sum[cell + 1] < level) ++cell;
            next.push_back(grid[cell] + (grid[cell + 1] - grid[cell]) * (level - sum[cell]) / (sum[cell + 1] - sum[cell]));
        }
        next.push_back(range.hi);
        grid = std::move(next);
        if (steps >= kMost) return grid;
    }
    // The spacing rule did not settle (a kink inside a step): halve what is still too long.
    for (int round = 0; round < kRounds; ++round) {
        const std::vector<double> probe = with_middles(grid);
        const std::vector<CurvePoint> p = curve(probe);
        std::vector<double> next;
        for (std::size_t i = 0; i + 1 < grid.size(); ++i) {
            next.push_back(grid[i]);
            if (step_excess(p[2 * i], p[2 * i + 1], p[2 * i + 2], limits) > 1.0) next.push_back(probe[2 * i + 1]);
        }
        next.push_back(grid.back());
        if (next.size() == grid.size() || next.size() >= kMost) break;
        grid = std::move(next);
    }
    return grid;
}

double curve_length(const Curve& curve, const Interval& range, int pieces) {
    const std::vector<CurvePoint> p = curve(linspace(range, pieces));
    double length = 0.0;
    for (std::size_t i = 1; i < p.size(); ++i) length += (p[i].p - p[i - 1].p).norm();
    return length;
}

Interval shrink(const Curve& curve, const Interval& range, double margin) {
    if (margin <= 0.0) return range;
    constexpr int kPieces = 512;
    const std::vector<double> t = linspace(range, kPieces);
    const std::vector<CurvePoint> p = curve(t);
    const auto walk = [&](bool forward) {
        double length = 0.0;
        for (std::size_t i = 1; i < t.size(); ++i) {
            const std::size_t a = forward ? i - 1 : t.size() - i, b = forward ? i : t.size() - 1 - i;
            const double piece = (p[b].p - p[a].p).norm();
            if (length + piece >= margin && piece > 0.0) return t[a] + (t[b] - t[a]) * (margin - length) / piece;
            length += piece;
        }
        return forward ? range.hi : range.lo;
    };
    return {walk(true), walk(false)};
}

}  // namespace trunnion
