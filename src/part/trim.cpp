// Even-odd queries against the trimming polygons, by rows.
#include <algorithm>

#include "trunnion/part/part.hpp"

namespace trunnion {

namespace {

/// An edge seen from the scan line c = const: it runs from (c0, x0) to (c1, x1), c being the coordinate across the line.
struct Edge {
    double c0, x0, c1, x1;
    double crossing(double c) const { return x0 + (x1 - x0) * ((c - c0) / (c1 - c0)); }
};

/// Edges bucketed by the scan coordinate c: row r lists the edges that reach into it.
struct Rows {
    Interval range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    double rows_per_unit = 0.0;
    std::vector<std::size_t> start;
    std::vector<Edge> edges;

    std::size_t row(double c) const {
        const double last = static_cast<double>(start.size() - 2);
        return static_cast<std::size_t>(std::clamp((c - range.lo) * rows_per_unit, 0.0, last));
    }

    Rows(const std::vector<std::vector<Vec2>>& loops, Eigen::Index across) {
        std::vector<Edge> all;
        for (const auto& loop : loops)
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
                range = {std::min(range.lo, a[across]), std::max(range.hi, a[across])};
                // An edge along the scan line never crosses it under either rule below.
                if (a[across] != b[across]) all.push_back({a[across], a[1 - across], b[across], b[1 - across]});
            }
        constexpr std::size_t kMostRows = 4096;  // long edges stand in every row they reach: keeps memory linear in practice
        const std::size_t rows = std::clamp<std::size_t>(all.size() / 2, 1, kMostRows);
        start.assign(rows + 1, 0);
        rows_per_unit = range.hi > range.lo ? static_cast<double>(rows) / range.length() : 0.0;
        const auto span = [&](const Edge& e) { return std::pair(row(std::min(e.c0, e.c1)), row(std::max(e.c0, e.c1))); };
        for (const Edge& e : all)
            for (auto [r, last] = span(e); r <= last; ++r) ++start[r + 1];
        for (std::size_t r = 0; r < rows; ++r) start[r + 1] += start[r];
        edges.resize(start.back());
        std::vector<std::size_t> next(start.begin(), start.end() - 1);
        for (const Edge& e : all)
            for (auto [r, last] = span(e); r <= last; ++r) edges[next[r]++] = e;
    }

    /// Sorted crossings of the line at c. A vertex on the line belongs to its lower side (closed_below) or to its upper one:
    /// the two rules differ only on a border along the line, which is inside under one of them.
    std::vector<double> crossings(double c, bool closed_below) const {
        std::vector<double> x;
        if (!range.contains(c)) return x;
        const std::size_t r = row(c);
        for (std::size_t k = start[r]; k < start[r + 1]; ++k) {
            const Edge& e = edges[k];
            const bool low0 = closed_below ? e.c0 <= c : e.c0 < c, low1 = closed_below ? e.c1 <= c : e.c1 < c;
            if (low0 != low1) x.push_back(e.crossing(c));
        }
        std::sort(x.begin(), x.end());
        return x;
    }
};

}  // namespace

struct Trim::Index {
    Rows by_u, by_v;
    explicit Index(const std::vector<std::vector<Vec2>>& loops) : by_u(loops, 0), by_v(loops, 1) {}
};

Trim::Trim(std::vector<std::vector<Vec2>> loops, double chord_error) : loops_(std::move(loops)), chord_error_(chord_error) {
    for (const auto& loop : loops_)
        for (const Vec2& p : loop) TRUNNION_REQUIRE(p.allFinite());
    std::erase_if(loops_, [](const auto& loop) { return loop.size() < 3; });
    if (!loops_.empty()) index_ = std::make_shared<const Index>(loops_);
}

bool Trim::contains(const Vec2& uv) const {
    if (whole_domain()) return true;
    for (const bool closed_below : {true, false}) {
        const std::vector<double> x = index_->by_v.crossings(uv.y(), closed_below);
        for (std::size_t k = 0; k + 1 < x.size(); k += 2)
            if (x[k] <= uv.x() && uv.x() <= x[k + 1]) return true;
    }
    return false;
}

std::vector<Interval> Trim::inside(bool along_u, double value, const Interval& range) const {
    if (whole_domain()) return {range};
    const Rows& rows = along_u ? index_->by_v : index_->by_u;
    std::vector<Interval> pieces;
    for (const bool closed_below : {true, false}) {
        const std::vector<double> x = rows.crossings(value, closed_below);
        for (std::size_t k = 0; k + 1 < x.size(); k += 2) {
            const Interval piece{std::max(x[k], range.lo), std::min(x[k + 1], range.hi)};
            if (piece.lo < piece.hi) pieces.push_back(piece);
        }
    }
    std::sort(pieces.begin(), pieces.end(), [](const Interval& a, const Interval& b) { return a.lo < b.lo; });
    std::vector<Interval> merged;  // union of both rules
    for (const Interval& piece : pieces) {
        if (!merged.empty() && piece.lo <= merged.back().hi)
            merged.back().hi = std::max(merged.back().hi, piece.hi);
        else
            merged.push_back(piece);
    }
    return merged;
}

}  // namespace trunnion
