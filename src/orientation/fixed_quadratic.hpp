// Relative curvature of a torus and a surface as sums of sinusoids of twice the yaw, times the corner radius so that a sharp
// corner is no exception (private). Source: fixed-axis sheet, section 3.
#pragma once

#include <algorithm>

#include "trunnion/orientation/fixed_estimate.hpp"

namespace trunnion {

/// How the axis leans over a sample.
struct FixedLean {
    double cosine = 0.0, sine = 0.0;  // of the inclination
    double cos2 = 1.0, sin2 = 0.0;    // of twice the yaw
    double kp = 0.0;                  // 1/mm, curvature of the parallel
    bool regular = true;              // the yaw is defined, or does not matter

    FixedLean(const FixedPatch::Sample& s, const Vec3& axis, const FixedTool& tool) {
        const double tf = axis.dot(s.f), tb = axis.dot(s.b), across2 = tf * tf + tb * tb;
        cosine = axis.dot(s.n);
        sine = std::sqrt(across2);
        if (sine > kParallelSine) {
            cos2 = (tf * tf - tb * tb) / across2;
            sin2 = 2.0 * tf * tb / across2;
        } else {
            regular = tool.R_major == 0.0;
        }
        kp = parallel_curvature(sine, tool);
    }
    static double parallel_curvature(double sine, const FixedTool& tool) {
        return tool.R_major == 0.0 ? 1.0 / tool.r : sine / (tool.R_major + tool.r * sine);
    }
};

/// r Q11 and r det Q.
struct ScaledForm {
    double q11 = 0.0, det = 0.0;
};

/// value(beta) = constant + c cos 2 beta + s sin 2 beta.
struct Sinusoid {
    double constant = 0.0, c = 0.0, s = 0.0;
    double at(double cos2, double sin2) const { return constant + c * cos2 + s * sin2; }
};
inline Sinusoid q11_of(const TangentForm& surface, double kp, double r) {
    return {0.5 * (1.0 + r * kp) - r * surface.q11, 0.5 * (1.0 - r * kp), 0.0};
}
inline Sinusoid det_of(const TangentForm& surface, double kp, double r) {
    const double half = 0.5 * (1.0 - r * kp);
    return {kp - 0.5 * (1.0 + r * kp) * (surface.q11 + surface.q22) + r * surface.determinant(),
            half * (surface.q11 - surface.q22), half * 2.0 * surface.q12};
}

inline ScaledForm scaled_form(const TangentForm& surface, const FixedLean& lean, const FixedTool& tool) {
    return {q11_of(surface, lean.kp, tool.r).at(lean.cos2, lean.sin2), det_of(surface, lean.kp, tool.r).at(lean.cos2, lean.sin2)};
}

}  // namespace trunnion
