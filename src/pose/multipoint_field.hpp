// One smooth block of a face, prepared for the two-point method: evaluation, a fixed lattice of samples for seeds, and a
// fixed tree of boxes with Taylor bounds for certificates (private).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "trunnion/part/part.hpp"

namespace trunnion::detail {

/// S over a parameter box as s + a x + e y + (shift + remainder), x and y in [-1, 1], |remainder_k| <= rem_k for each coordinate
/// and |remainder| <= rem_norm. `s` is the surface's point at the centre.
struct TaylorBox {
    Vec3 s, shift, a, e, rem;
    double rem_norm = 0.0;
};

/// 8 x 8 samples with a rim of one: the neighbours that tell a local maximum. Row by row; what lies outside the face is far away.
struct Tile {
    static constexpr int kSide = 10, kSize = kSide * kSide, kPadded = 104;  ///< padded to whole vectors
    static constexpr double kFar = 1e30;  // so far that no formula overflows: squares stay below 1e300
    std::array<double, kPadded> x, y, z;
    Vec3 centre = Vec3::Zero();
    double radius = 0.0;
    std::uint32_t field = 0;
    int first_u = 0, first_v = 0;  ///< lattice index of sample (1, 1)
};

/// Where a certificate looks: a box of a span, by centre and half sizes in the span's own [-1, 1].
struct SpanBox {
    std::uint32_t field = 0, span = 0;
    double x = 0.0, y = 0.0, h = 1.0;
    std::int64_t node = 0;  ///< in the tree of the span, or -1 below its leaves
};

class Field {
public:
    /// `block_*`: parameter range without creases. `trim` may be null. `spacing`: mm, wanted between samples.
    Field(const Surface& surface, std::shared_ptr<const Trim> trim, int face, const Interval& block_u, const Interval& block_v,
          double spacing);

    int face() const { return face_; }
    const Interval& u() const { return u_; }
    const Interval& v() const { return v_; }
    bool inside(double u, double v) const { return !trim_ || trim_->whole_domain() || trim_->contains({u, v}); }
    bool trimmed() const { return trim_ && !trim_->whole_domain(); }
    const Trim* trim() const { return trim_.get(); }
    const Surface& surface() const { return surface_; }

    SurfacePoint at(double u, double v) const;
    bool exact_near() const { return polynomial_; }  ///< whether Near loses nothing to cancellation

    std::vector<double> lattice_u, lattice_v;  ///< parameters of the samples
    void append_tiles(std::uint32_t index, std::vector<Tile>& tiles) const;

    std::size_t spans() const { return spans_.size(); }
    Box3 span_box(std::size_t span) const;
    Vec2 parameters(const SpanBox& box) const;
    /// Half sizes of the box in u and v.
    Vec2 half_sizes(const SpanBox& box) const;
    const TaylorBox& root(std::size_t span) const { return nodes_[spans_[span].first_node]; }
    /// The Taylor box of `box`, from the tree or made anew.
    TaylorBox taylor(const SpanBox& box) const;
    const TaylorBox* stored(const SpanBox& box) const {
        return box.node >= 0 ? &nodes_[spans_[box.span].first_node + static_cast<std::size_t>(box.node)] : nullptr;
    }
    /// The four children.
    std::array<SpanBox, 4> children(const SpanBox& box) const;

    /// Exact displacement S(u, v) - S(P) near a point of it: from Taylor coefficients about P where the span is polynomial, so
    /// that nothing cancels. The normal part of the first derivatives is removed where `n` is given (P interior, tangent).
    class Near {
    public:
        Near(const Field& field, double u, double v, const std::optional<Vec3>& n);
        SurfacePoint at(double u, double v) const;  ///< S is the displacement

    private:
        const Field& field_;
        Vec3 origin_;
        std::optional<std::size_t> span_;
        double u_, v_, scale_u_ = 1.0, scale_v_ = 1.0;
        std::array<double, 4 * 36> c_{};
        int nu_ = 0, nv_ = 0;
    };

private:
    friend class Near;
    struct Span {
        Interval u, v;
        double cu = 0.0, cv = 0.0, inverse_u = 1.0, inverse_v = 1.0;  // local x = (u - cu) inverse_u
        std::size_t coefficients = 0;                                 // (nu + 1)(nv + 1) x 4, [i][j][xyz0], if polynomial
        std::size_t first_node = 0;
        int depth = 0;
    };
    std::size_t locate(double u, double v) const;
    TaylorBox shifted(const Span& span, double x, double y, double h) const;
    TaylorBox bounded(const Span& span, double x, double y, double h) const;
    void make_spans(double spacing);

    Surface surface_;
    std::shared_ptr<const Trim> trim_;
    int face_;
    Interval u_, v_;
    std::vector<double> breaks_u_, breaks_v_;
    std::vector<Span> spans_;  // row-major in breaks
    bool polynomial_ = false;
    int nu_ = 0, nv_ = 0;
    std::vector<double> coefficients_;
    std::vector<TaylorBox> nodes_;
};

/// The blocks of a face between its creases (knots of full multiplicity).
std::vector<Field> fields_of(const Surface& surface, const Trim& trim, int face, double spacing);

}  // namespace trunnion::detail
