// Lower bounds of the signed distance to one rotational piece of the tool (private to the check room).
//
// In the tool's frame (tip at the origin, axis = z) the distance is f(X) = F(rho, z), F the profile's signed distance,
// convex in (rho, z). From one evaluation at X0 with gradient g,
//     f(X) >= f(X0) + g.(X - X0) - bend |X - X0|^2,    bend = max(0, -F_rho) / (2 rho0):
// where F_rho >= 0 because rho(X) is convex in X; where F_rho < 0 (only the inner side of an annular piece) because
// rho(X) <= rho0 + e_r.(X - X0) + |X - X0|^2 / (2 rho0). Closed pieces have bend = 0 everywhere: they are convex.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/cutter/profile.hpp"

namespace trunnion {

struct ToolFrame {
    Mat3 to_tool;  // rows: x, y, axis
    Vec3 tip;
    static ToolFrame at(const Vec3& tip, const Vec3& axis) {
        const Vec3 x = any_perpendicular(axis);
        Mat3 m;
        m.row(0) = x.transpose();
        m.row(1) = axis.cross(x).transpose();
        m.row(2) = axis.transpose();
        return {m, tip};
    }
    Vec3 point(const Vec3& world) const { return to_tool * (world - tip); }
    Vec3 world(const Vec3& tool) const { return tip + to_tool.transpose() * tool; }
};

struct Sample {
    double f = 0.0;
    Vec3 g = Vec3::Zero();
    double bend = 0.0;
};

inline Sample sample(const Profile& profile, const Vec3& X) {
    const double rho = std::sqrt(X.x() * X.x() + X.y() * X.y());
    const ProfileDistance d = profile.distance(rho, X.z());
    Sample s;
    s.f = d.distance;
    if (rho > 0.0) {
        const double k = d.gradient.x() / rho;
        s.g = {k * X.x(), k * X.y(), d.gradient.y()};
        if (d.gradient.x() < 0.0) s.bend = -0.5 * k;
    } else {
        s.g = {0.0, 0.0, d.gradient.y()};  // a subgradient: F does not fall with rho on a closed piece
        if (d.gradient.x() < 0.0) s.bend = std::numeric_limits<double>::infinity();
    }
    return s;
}

/// Lower bound of f over an axis-aligned box (in the world) of half sizes `half` about a centre given in the tool frame.
inline double box_bound(const Profile& profile, const ToolFrame& frame, const Vec3& centre, const Vec3& half) {
    const Sample s = sample(profile, frame.point(centre));
    const Vec3 g = frame.to_tool.transpose() * s.g;
    double bound = s.f - g.cwiseAbs().dot(half);
    // fmax: a point on the axis of an open piece has an infinite bend, and a box without size makes that NaN.
    if (s.bend > 0.0) bound = std::fmax(bound - s.bend * half.squaredNorm(), s.f - half.norm());
    return bound;
}

/// Lower bounds at the corners of a triangle, one row per sample: f >= row . barycentric coordinates.
using TangentRows = std::array<Vec3, 3>;
inline TangentRows tangent_rows(const std::array<Vec3, 3>& X, const std::array<Sample, 3>& s) {
    TangentRows rows;
    for (std::size_t i = 0; i < 3; ++i) {
        double reach2 = 0.0;
        for (std::size_t j = 0; j < 3; ++j) {
            const Vec3 a = X[j] - X[i];
            rows[i][static_cast<Eigen::Index>(j)] = s[i].f + s[i].g.dot(a);
            reach2 = std::max(reach2, a.squaredNorm());
        }
        if (s[i].bend > 0.0) {
            rows[i].array() -= s[i].bend * reach2;
            const double lipschitz = s[i].f - std::sqrt(reach2);
            if (!(rows[i].minCoeff() > lipschitz)) rows[i].setConstant(lipschitz);
        }
    }
    return rows;
}

/// Lower bound of f over a triangle from the better one of its corners' tangents.
inline double corner_bound(const TangentRows& rows) {
    return std::max({rows[0].minCoeff(), rows[1].minCoeff(), rows[2].minCoeff()});
}

/// The same from all three together: every mixture of the rows is a bound, the best one is the value of a 3 x 3 matrix game.
/// It stays tight where single tangents fail: across ridges of f (points equally far from two sides of the tool).
double mixed_bound(const TangentRows& rows);

struct TriangleMinimum {
    double lower = 0.0;  // proved
    double value = 0.0;  // attained at X, unless lower >= enough
    Vec3 X = Vec3::Zero();
};

/// Minimum of f along the edge from A to B for a closed (convex) piece, to `gap`. Stops early once lower >= enough.
TriangleMinimum edge_minimum(const Profile& profile, const Vec3& A, const Vec3& B, const Sample& a, const Sample& b, double gap,
                             double enough);

/// Minimum of f over a flat triangle for a closed (convex) piece. To `gap` wherever it lies outside the tool, or no deeper in it
/// than the tool is round there; otherwise lower and value enclose it and the triangle has to be split. Stops early once
/// lower >= enough.
TriangleMinimum triangle_minimum(const Profile& profile, const std::array<Vec3, 3>& X, const std::array<Sample, 3>& s, double gap,
                                 double enough);

}  // namespace trunnion
