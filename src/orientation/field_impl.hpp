// What an orientation field holds (private).
#pragma once

#include "orientation/field_sum.hpp"
#include "orientation/field_system.hpp"
#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion {

namespace detail {

/// Where points lie in the space in which distances are Euclidean, and how that changes with u and v.
struct FeaturePoints {
    SumPoints x;
    std::array<std::vector<double>, 3> x_u, x_v;  // with order 1
    SurfaceBatch surface;                         // where the distance, the tail or the mode needs it
};

/// Many keys: overlapping cells with a small system each, blended by Wendland weights (sheet, section 5.5).
struct Partition {
    int cells_u = 1, cells_v = 1;
    double scale_u = 1.0, scale_v = 1.0;  // metric: (scale_u u, scale_v v)
    double radius = 0.0;                  // of a patch, in the metric
    bool wrapped = false;
    KernelSum sum;                   // all patches one after the other, padded to eight keys
    std::vector<std::size_t> first;  // cells + 1
    std::vector<Vec3> constant;      // tail per cell
    double rcond = 1.0, residual = 0.0;

    void evaluate(double u, double v, bool derivatives, Vec3& R, Vec3& Ru, Vec3& Rv) const;
};
Result<Partition> make_partition(const std::vector<FieldKey>& keys, const FieldOptions& options, const Control& control);

}  // namespace detail

struct OrientationField::Impl {
    FieldSurface surface;
    FieldOptions options;         // resolved
    std::vector<FieldKey> keys;   // merged
    std::vector<FieldKey> given;  // as they came, unit axes
    detail::KernelSum sum;        // coordinates of the keys and coefficients
    Eigen::MatrixXd tail;         // (m, 3)
    Vec3 tail_centre = Vec3::Zero();
    double tail_scale = 1.0;
    std::optional<detail::KeySystem> system;
    Vec3 base = Vec3::UnitZ();  // logmap
    Mat3 base_frame = Mat3::Identity();
    std::optional<detail::Partition> partition;
    std::optional<Surface> spline;
    FieldReport report;

    explicit Impl(FieldSurface s) : surface(std::move(s)) {}

    bool wrapped() const { return options.half_open; }
    double wrap(double v) const { return options.half_open ? v - std::floor(v) : v; }
    bool needs_surface() const;
    detail::SumSpace space() const;
    /// u, v already wrapped.
    void features(std::span<const double> u, std::span<const double> v, int order, detail::FeaturePoints& out) const;
    /// Columns of the tail at one point and its derivatives: at most 4.
    int tail_columns() const;
    void tail_row(double u, double v, const SurfaceBatch* surface, std::size_t i, double* row, double* row_u,
                  double* row_v) const;
    /// The field before the spline. u, v wrapped; all arrays of `out` sized.
    Result<void> evaluate_chunk(std::span<const double> u, std::span<const double> v, int order, std::size_t first,
                                FieldBatch& out) const;
    Result<void> evaluate_karcher(const detail::FeaturePoints& f, std::span<const double> u, std::span<const double> v, int order,
                                  std::size_t first, FieldBatch& out) const;
    /// with_spline: the spline where there is one.
    Result<void> evaluate(std::span<const double> u, std::span<const double> v, int order, bool with_spline, FieldBatch& out,
                          const Control& control) const;
};

namespace detail {

using FieldImpl = OrientationField::Impl;

/// Length check, certificate, key angles and indices. Error: `toff: field vanishes ...`, a missed key.
Result<void> measure(FieldImpl& field, const Control& control);
/// The key matrix (ridge included) and tail matrix for a kernel.
Eigen::MatrixXd key_matrix(const FieldImpl& field, const Kernel& kernel, double ridge);
Eigen::MatrixXd tail_matrix(const FieldImpl& field);
/// The values that are interpolated, (M, 3).
Result<Eigen::MatrixXd> interpolated_values(FieldImpl& field);
/// Closest pair of keys.
std::array<std::size_t, 2> closest_keys(const FieldImpl& field);
double feature_distance(const FieldImpl& field, std::size_t a, std::size_t b);

}  // namespace detail
}  // namespace trunnion
