// Orientation fields: one smooth function T(u, v) over a surface through key tool axes.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/orientation/field_kernel.hpp"
#include "trunnion/orientation/field_surface.hpp"

namespace trunnion {

/// chord: |S(P) - S(Q)| scale. param: hypot(su du, sv dv). cylinder: hypot(q du, dv wrapped to half a turn).
/// embedded_cylinder: the chord between ((cos 2 pi v)/2 pi, (sin 2 pi v)/2 pi, q u), smooth everywhere.
enum class FieldDistance { automatic, chord, param, cylinder, embedded_cylinder };
/// raw: the interpolated vector, normalised on use (Huang et al. 2016). logmap, karcher, lean: unit by construction, on the
/// sphere: tangent coordinates at one base axis, the weighted spherical mean of the keys, tangent coordinates at the surface
/// normal.
enum class FieldMode { raw, logmap, karcher, lean };
/// Polynomial beside the kernels: constant 1; linear 1, u, v (half-open: 1, u); spatial 1, x, y, z.
enum class FieldTail { automatic, none, constant, linear, spatial };
enum class FieldKnots { averaged, uniform };
enum class FieldSamples { unit, raw };
enum class FieldSolver { automatic, dense, partition };

std::string_view name_of(FieldDistance distance);
std::string_view name_of(FieldMode mode);
std::string_view name_of(FieldTail tail);

struct FieldKey {
    Vec2 uv = Vec2::Zero();     ///< the field's parameters, [0, 1] each
    Vec3 axis = Vec3::UnitZ();  ///< any length
    bool user = true;           ///< false: placed by the repair loop
};

struct FieldOptions {
    bool half_open = false;  ///< v closed with period 1
    Kernel kernel;
    bool auto_shape = false;  ///< shape by leave-one-out
    FieldDistance distance = FieldDistance::automatic;
    double scale = 0.0;         ///< chord, 1/mm; 0: one over the diagonal of the keys' box
    double su = 1.0, sv = 1.0;  ///< param
    double q = 0.0;             ///< cylinders; 0: of the smallest enclosing cylinder
    FieldMode mode = FieldMode::raw;
    FieldTail tail = FieldTail::automatic;  ///< none with raw, constant with the other modes
    double ridge = 0.0;                     ///< relative to phi(0); 0: the keys are met
    bool auto_ridge = false;                ///< ridge by leave-one-out
    FieldSolver solver = FieldSolver::automatic;
    std::optional<Vec3> base;                  ///< logmap: base axis; empty: spherical mean of the keys
    double lean_cap = kPi / 2;                 ///< rad, mode lean: leans above 0.8 of it are bent back below it
    double normal_limit = radians(80.0);       ///< rad, greatest angle of a key axis and the outward normal
    std::optional<std::array<int, 2>> spline;  ///< N_u, N_v: sample and interpolate by a tensor B-spline
    double spline_tolerance = 0.0;             ///< rad; > 0: double N_u, N_v until no key is missed by more
    int degree = 3;                            ///< of the spline: 1, 2 (open only) or 3
    FieldKnots knots = FieldKnots::averaged;
    FieldSamples samples = FieldSamples::unit;
    std::array<int, 2> grid{101, 101};  ///< of the indices and of the check of lengths
};

/// Values at N points. raw: the vector before normalising (= unit in the modes that are unit by construction).
/// Derivatives by the field's parameters; empty when not asked for.
struct FieldBatch {
    std::vector<Vec3> unit, raw, unit_u, unit_v, raw_u, raw_v;
};

/// Indices over a grid of N_u x N_v points, ends included. Source: Huang et al. 2016, Eqs. 8, 9 with the parentheses and the
/// spacing mended (S_TD); S_D = mean of (|t_u|^2 + |t_v|^2) / 2 by the same differences. S_TD is no measure of smoothness (it
/// vanishes for T = h(u - v)) and serves for comparison with the paper.
struct FieldIndices {
    double S_TD = 0.0, S_D = 0.0;
};
/// Shapes: values (N_u N_v,), index i N_v + j. Requires at least 3 points each way.
FieldIndices grid_indices(const std::vector<Vec3>& values, int count_u, int count_v);

struct FieldReport {
    std::size_t keys = 0, merged = 0;
    Kernel kernel;  ///< with its shape
    FieldDistance distance = FieldDistance::chord;
    FieldTail tail = FieldTail::none;
    double scale = 0.0, q = 0.0, ridge = 0.0;
    bool partition = false;
    double rcond = 0.0;     ///< reciprocal condition, 1-norm, of the system solved; least of all cells of a partition
    double residual = 0.0;  ///< greatest |A c - T|
    double least_raw = 1.0, greatest_raw = 1.0;
    Vec2 least_raw_uv = Vec2::Zero();
    bool certified = false;                        ///< |R| > 0.05 proved over the whole surface, not only on the grid
    double largest_angle = 0.0, mean_angle = 0.0;  ///< rad, of the axis of a key and the field there
    double I_fa = 1.0,
           I_fa_raw = 1.0;   ///< mean over the keys as given of T_k . t, Eq. 11 (raw: t not normalised, as the paper has it)
    FieldIndices unit, raw;  ///< of the field as used
    FieldIndices rbf_unit, rbf_raw;  ///< of the field before the spline (the same without one)
    double E_D = 0.0;                ///< Dirichlet energy, parametrisation-free, dimensionless
    double fill_distance = 0.0;      ///< largest distance of a surface point from its nearest key (41 x 41 grid)
    std::optional<double> loo;       ///< rms leave-one-out error of the shape chosen
    std::array<int, 2> spline{0, 0};
    std::vector<std::string> warnings;
};

class OrientationField {
public:
    /// Builds, checks and measures. Errors and warnings as in section 7 of the sheet ("toff: ..."), keys counted from 0.
    static Result<OrientationField> build(const FieldSurface& surface, std::vector<FieldKey> keys, const FieldOptions& options,
                                          const Control& control);

    /// Field at N points; parameters as FieldKey::uv, wrapped in a closed direction. order 1: with derivatives.
    /// Same bits for any number of threads. Error: no_solution where the spherical mean does not settle or a lean frame
    /// degenerates.
    Result<void> evaluate(std::span<const double> u, std::span<const double> v, int order, FieldBatch& out,
                          const Control& control = {}) const;
    /// One axis. Requires a field that evaluates at (u, v).
    Vec3 axis(double u, double v) const;

    const FieldReport& report() const;
    const FieldOptions& options() const;        ///< as resolved
    const std::vector<FieldKey>& keys() const;  ///< after merging, unit axes
    const FieldSurface& surface() const;
    /// Leave-one-out errors e_k = c_k / (A^-1)_kk, (M,) vectors in the space that is interpolated. Requires a dense solve.
    std::vector<Vec3> leave_one_out() const;

    struct Impl;  // src/orientation/field_impl.hpp

private:
    explicit OrientationField(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    std::shared_ptr<const Impl> impl_;
};

}  // namespace trunnion
