// The slow twin of the check room: least distance of a tool piece to triangles, from nothing but the twin of its profile
// (reference_profile.hpp) evaluated at points. Two searches, both without bounds taken from the engine:
//  - `lipschitz_minimum`: subdivision; a signed distance changes by at most the way, so a triangle holds nothing below
//    f(centroid) - circumradius about it. Certified to `gap` for every piece.
//  - `convex_minimum`: nested golden-section search in barycentric coordinates, good to rounding for convex pieces
//    (a convex function has no other minimum to fall into). Found, not certified.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

using DistanceField = std::function<double(const Vec3&)>;
using Corners = std::array<Vec3, 3>;

struct BruteMinimum {
    double lower = std::numeric_limits<double>::infinity();  // proved (up to rounding)
    double value = std::numeric_limits<double>::infinity();  // attained at `point`
    Vec3 point = Vec3::Zero();
    bool complete = true;  // false: the work limit was hit, `lower` is not tight
};

inline void lipschitz_minimum(const DistanceField& f, const Corners& triangle, double gap, std::size_t work, BruteMinimum& best) {
    struct Item {
        Corners x;
        double f;
    };
    const auto centroid = [](const Corners& x) { return Vec3((x[0] + x[1] + x[2]) / 3.0); };
    const auto offer = [&](const Vec3& p) {
        const double value = f(p);
        if (value < best.value) best.value = value, best.point = p;
        return value;
    };
    for (const Vec3& corner : triangle) offer(corner);
    std::vector<Item> open{{triangle, offer(centroid(triangle))}};
    while (!open.empty()) {
        const Item item = open.back();
        open.pop_back();
        const Vec3 c = centroid(item.x);
        double radius = 0.0;
        for (const Vec3& corner : item.x) radius = std::max(radius, (corner - c).norm());
        const double bound = item.f - radius;
        if (bound >= best.value - gap || work == 0) {
            best.complete = best.complete && work > 0;
            best.lower = std::min(best.lower, bound);
            continue;
        }
        const Vec3 a = 0.5 * (item.x[1] + item.x[2]), b = 0.5 * (item.x[2] + item.x[0]), d = 0.5 * (item.x[0] + item.x[1]);
        for (const Corners& part :
             {Corners{item.x[0], d, b}, Corners{d, item.x[1], a}, Corners{b, a, item.x[2]}, Corners{a, b, d}}) {
            open.push_back({part, offer(centroid(part))});
            --work;
            if (work == 0) break;
        }
        if (work == 0) best.complete = false, best.lower = -std::numeric_limits<double>::infinity();
    }
    best.lower = std::min(best.lower, best.value);
}

/// Least value of a convex function of one variable on [0, 1].
template <class G>
std::pair<double, double> golden(G g, int steps) {
    constexpr double kRatio = 0.6180339887498949;
    double a = 0.0, b = 1.0, x = b - kRatio * (b - a), y = a + kRatio * (b - a), gx = g(x), gy = g(y);
    std::pair<double, double> best{g(0.0), 0.0};
    const auto keep = [&](double value, double at) {
        if (value < best.first) best = {value, at};
    };
    keep(g(1.0), 1.0);
    keep(gx, x);
    keep(gy, y);
    for (int i = 0; i < steps; ++i) {
        if (gx <= gy) {
            b = y, y = x, gy = gx;
            x = b - kRatio * (b - a), gx = g(x);
            keep(gx, x);
        } else {
            a = x, x = y, gx = gy;
            y = a + kRatio * (b - a), gy = g(y);
            keep(gy, y);
        }
    }
    return best;
}

inline void convex_minimum(const DistanceField& f, const Corners& x, int steps, BruteMinimum& best) {
    // A point of the triangle: on the segment from corner 0 to a point of the opposite edge; convex in both variables together
    // when written with the edge's own fractions.
    const auto line = [&](double v) {
        const Vec3 a = x[0] + v * (x[1] - x[0]), b = x[0] + v * (x[2] - x[0]);
        return golden([&](double w) { return f(a + w * (b - a)); }, steps);
    };
    const auto outer = golden([&](double v) { return line(v).first; }, steps);
    const auto inner = line(outer.second);
    if (inner.first < best.value) {
        const Vec3 a = x[0] + outer.second * (x[1] - x[0]), b = x[0] + outer.second * (x[2] - x[0]);
        best.value = inner.first;
        best.point = a + inner.second * (b - a);
    }
}

/// Least distance by the nested search over many triangles; those a 1-Lipschitz function cannot reach are passed over.
inline BruteMinimum convex_minimum(const DistanceField& f, const std::vector<Corners>& triangles, int steps = 45) {
    BruteMinimum best;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Vec3 c = (triangles[i][0] + triangles[i][1] + triangles[i][2]) / 3.0;
        double radius = 0.0;
        for (const Vec3& corner : triangles[i]) radius = std::max(radius, (corner - c).norm());
        order.emplace_back(f(c) - radius, i);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [bound, i] : order) {
        if (bound >= best.value) break;
        convex_minimum(f, triangles[i], steps, best);
    }
    best.lower = best.value;
    return best;
}

inline BruteMinimum lipschitz_minimum(const DistanceField& f, const std::vector<Corners>& triangles, double gap,
                                      std::size_t work = 3'000'000) {
    BruteMinimum best;
    for (const Corners& t : triangles) lipschitz_minimum(f, t, gap, work, best);
    return best;
}

/// Distance of a point from a triangle in space (Voronoi regions written as plain minimisation).
inline double distance_to_triangle(const Vec3& p, const Corners& x) {
    BruteMinimum best;
    convex_minimum([&](const Vec3& q) { return (q - p).norm(); }, x, 60, best);
    return best.value;
}

}  // namespace trunnion
