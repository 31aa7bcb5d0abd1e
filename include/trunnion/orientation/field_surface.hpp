// A surface as orientation fields see it: u and v from 0 to 1, the closed direction (if any) v.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "trunnion/part/surface.hpp"

namespace trunnion {

/// Cheap to copy; all calls are thread-safe. Parameters outside [0, 1] are clamped, by the surface or by its function.
class FieldSurface {
public:
    enum class Closed { automatic, u, v };
    /// `closed`: which native parameter becomes the field's v. automatic: u where only u is closed, else v as it is.
    static FieldSurface of(const Surface& surface, Closed closed = Closed::v);
    /// Any function of (u, v) in [0, 1]^2; second derivatives are used by mode `lean` only. normal_sign: +1 where S_u x S_v
    /// points outward.
    using Function = std::function<SurfacePoint(double u, double v)>;
    static FieldSurface of(Function function, double normal_sign = 1.0);

    /// `order` planes as Surface::evaluate, by the field's parameters.
    void evaluate(std::span<const double> u, std::span<const double> v, int order, SurfaceBatch& out) const;
    SurfacePoint at(double u, double v) const;
    Vec3 point(double u, double v) const { return at(u, v).S; }
    /// Outward unit normal; empty at a pole.
    std::optional<Vec3> normal(double u, double v) const;
    double normal_sign() const { return sign_; }

    Vec2 to_field(const Vec2& native) const;
    Vec2 to_native(const Vec2& field) const;
    bool swapped() const { return swapped_; }
    /// Whether v = 0 and v = 1 are the same curve in space.
    bool closed_v() const;
    const Surface* surface() const { return surface_ ? &*surface_ : nullptr; }

    /// Rigorous bounds of |S_u| and |S_v| over a box of the field's parameters; empty for a function.
    struct SlopeBound {
        double u = 0.0, v = 0.0;
    };
    std::optional<SlopeBound> slope_bound(const Interval& u, const Interval& v) const;

    /// Height over (pi times diameter) of the smallest cylinder about the surface's axis: z for analytic surfaces, else the line
    /// through the centroids of the loops u = 0 and u = 1. Sampled.
    double cylinder_ratio() const;

private:
    FieldSurface() = default;
    std::optional<Surface> surface_;
    Function function_;
    Interval u_{0.0, 1.0}, v_{0.0, 1.0};  // native
    bool swapped_ = false;
    double sign_ = 1.0;
};

}  // namespace trunnion
