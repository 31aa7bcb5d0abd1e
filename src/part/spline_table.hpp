// A B-spline surface cut into Bezier patches once, so that any point needs one table look-up and one tensor product.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "trunnion/part/surface.hpp"

namespace trunnion::detail {

inline constexpr int kMaxDegree = 25;  ///< as in Open CASCADE; a Bernstein basis of this degree is still well conditioned
inline constexpr double kUlp = std::numeric_limits<double>::epsilon();

/// The knot spans of one parameter direction that have length.
class SpanAxis {
public:
    SpanAxis() = default;
    /// Requires valid knots (non-decreasing, size count + degree + 1, domain of positive length).
    SpanAxis(int degree, const std::vector<double>& knots);

    int degree() const { return degree_; }
    std::size_t spans() const { return inverse_length_.size(); }
    const std::vector<double>& breaks() const { return breaks_; }
    double inverse_length(std::size_t span) const { return inverse_length_[span]; }
    /// Index of the knot that starts the span: the span's control points are [knot - degree, knot].
    std::size_t knot_index(std::size_t span) const { return knot_index_[span]; }
    /// Multiplicity of the knot at break i.
    int multiplicity(std::size_t break_index) const { return multiplicity_[break_index]; }
    double clamp(double t) const { return std::min(std::max(t, breaks_.front()), breaks_.back()); }
    struct Place {
        std::uint32_t span;
        double local;  ///< position within the span, in [0, 1]; times the span's length from its start
    };
    /// The span with breaks[i] <= t < breaks[i + 1], the last one also at its end; t is clamped first, NaN falls into span 0.
    Place locate(double t) const {
        t = clamp(t);
        // Monotone in t: every knot in a lower bucket is at most t, every one in a higher bucket above it.
        const Bucket& bucket = buckets_[bucket_of(t)];
        std::uint32_t span = bucket.first_span + static_cast<std::uint32_t>(t >= bucket.next_break);  // no branch to mispredict
        if (bucket.crowded)
            while (t >= starts_[span + 1].start) ++span;
        return {span, (t - starts_[span].start) * starts_[span].inverse_length};
    }

private:
    int degree_ = 0;
    std::vector<double> breaks_, inverse_length_;
    std::vector<std::size_t> knot_index_;
    std::vector<int> multiplicity_;

    struct Start {
        double start, inverse_length;
    };
    std::vector<Start> starts_;  // one more than spans: the last starts at infinity
    struct Bucket {
        double next_break;         // start of the first span that begins within the bucket; infinity if there is none
        std::uint32_t first_span;  // of the bucket's beginning
        bool crowded;              // more than one span begins within
    };
    std::vector<Bucket> buckets_;
    double buckets_per_unit_ = 0.0;

    std::size_t bucket_of(double t) const {
        const double offset = std::max(0.0, (t - breaks_.front()) * buckets_per_unit_);  // NaN becomes 0
        return static_cast<std::uint32_t>(std::min(offset, static_cast<double>(buckets_.size() - 1)));
    }
};

/// Degrees up to which patches are evaluated in powers of the centred local parameter x in [-1, 1]: half the work of the
/// Bernstein form. A polynomial bounded by 1 there has coefficients that add up to at most (1 + sqrt 2)^degree (Chebyshev's
/// do), so that a patch of size L loses at most 41^2 ulp of L at degree 5 and 7^2 at degree 3, and far less if it is smooth;
/// L is the patch, not its distance from the origin.
inline constexpr int kPowerDegree = 5;

/// Bezier patches of all span pairs. Patch (su, sv) holds `components` nets of (degree_u + 1) x (degree_v + 1) values,
/// row-major, net after net: x, y, z (and the weight) of the homogeneous control points relative to `origin` of the patch.
/// The origin is one of the patch's own control points: derivatives then lose digits only to the size of the patch, not
/// to its distance from the WCS origin.
struct PatchTable {
    SpanAxis u, v;
    int components = 3;
    std::size_t stride = 0;  ///< doubles per patch: components * (degree_u + 1) * (degree_v + 1)
    std::vector<double> coefficients;
    std::vector<Vec3> origins;

    std::size_t patch(std::size_t span_u, std::size_t span_v) const { return span_u * v.spans() + span_v; }
    const double* net(std::size_t patch) const { return coefficients.data() + patch * stride; }
    bool rational() const { return components == 4; }
    /// Whether the nets hold power coefficients (x^i y^j) instead of Bezier points.
    bool powers = false;
};
PatchTable make_patches(const BSplineData& data);
/// The same patches ready for evaluation: in powers if both degrees allow it. Bounds are made from the Bezier form before.
PatchTable ready(PatchTable patches);

/// Rigorous second-derivative bounds per cell: every patch is divided into a few cells, each bounded by the control nets of
/// its derivatives. Kinks are bounds of the jump of the first derivative across a knot line of full multiplicity.
class BoundTable {
public:
    BoundTable() = default;
    explicit BoundTable(const PatchTable& patches);
    SecondDerivativeBound over(const PatchTable& patches, const Interval& u, const Interval& v) const;

private:
    std::size_t cells_u_ = 1, cells_v_ = 1;  // per span
    std::vector<SecondDerivativeBound> cells_;
    std::vector<double> kinks_u_, kinks_v_;  // [break][span of the other direction]; empty without kinks
};

/// Evaluates points through the patches: the hot loop (spline_kernel.cpp).
void evaluate_patches(const PatchTable& patches, std::span<const double> u, std::span<const double> v, int order,
                      SurfaceBatch& out);
SurfacePoint evaluate_patch_at(const PatchTable& patches, double u, double v, int order);

}  // namespace trunnion::detail
