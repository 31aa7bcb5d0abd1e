#include "trunnion/part/surface.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "part/analytic.hpp"
#include "part/spline_table.hpp"

namespace trunnion {

using detail::kUlp;

/// What all copies of a surface share. Exactly one of spline and analytic is set.
struct Surface::Impl {
    struct Spline {
        BSplineData data;
        detail::PatchTable patches;
        detail::BoundTable bounds;
    };
    std::shared_ptr<const Spline> spline;
    std::optional<AnalyticData> analytic;
    Domain domain;
    std::vector<double> breaks_u, breaks_v;
    double noise_u = 0.0, noise_v = 0.0;  ///< rounding of |S_u|, |S_v|: what is not above it is zero
};

void SurfaceBatch::resize(std::size_t count, int order) {
    TRUNNION_REQUIRE(order >= 0 && order <= 2);
    count_ = count;
    order_ = order;
    data_.resize(count * (order == 0 ? 3 : order == 1 ? 9 : 18));
}

SurfacePoint SurfaceBatch::at(std::size_t i) const {
    TRUNNION_REQUIRE(order_ == 2 && i < count_);
    const auto vec = [&](int k) { return Vec3(plane(k)[i], plane(k + 1)[i], plane(k + 2)[i]); };
    return {vec(0), vec(3), vec(6), vec(9), vec(12), vec(15)};
}

namespace {

Result<void> check_knots(const std::vector<double>& knots, int degree, std::size_t count, char axis) {
    const auto bad = [](std::string what) { return fail(ErrorCode::invalid_input, std::move(what)); };
    if (degree < 1 || degree > detail::kMaxDegree)
        return bad(fmt::format("degree {} along {} must lie between 1 and {}", degree, axis, detail::kMaxDegree));
    const std::size_t order = static_cast<std::size_t>(degree) + 1;
    if (count < order) return bad(fmt::format("{} control points along {} are too few for degree {}", count, axis, degree));
    if (knots.size() != count + order)
        return bad(fmt::format("{} knots along {} where {} control points of degree {} need {}", knots.size(), axis, count,
                               degree, count + order));
    for (std::size_t k = 0; k < knots.size(); ++k) {
        if (!std::isfinite(knots[k])) return bad(fmt::format("knot {} along {} is not a number", k, axis));
        if (k > 0 && knots[k] < knots[k - 1])
            return bad(
                fmt::format("knot {} along {} ({}) is smaller than the one before it ({})", k, axis, knots[k], knots[k - 1]));
    }
    if (!(knots[order - 1] < knots[count])) return bad(fmt::format("the knots along {} leave an empty domain", axis));
    for (std::size_t k = 1; k + order <= count + order - 1; ++k)
        if (knots[k] == knots[k + order - 1] && knots[k] > knots[order - 1] && knots[k] < knots[count])
            return bad(fmt::format("knot {} along {} ({}) is repeated more often than the degree: the surface would tear there",
                                   k, axis, knots[k]));
    return {};
}

/// Whether the two end curves of one direction coincide: their Bezier rows, span by span, up to rounding.
bool ends_coincide(const detail::PatchTable& table, bool along_u, double size) {
    const std::size_t nu = static_cast<std::size_t>(table.u.degree()) + 1, nv = static_cast<std::size_t>(table.v.degree()) + 1;
    const double allowed = 64.0 * kUlp * size;
    const std::size_t across = along_u ? table.v.spans() : table.u.spans(), row = along_u ? nv : nu;
    for (std::size_t s = 0; s < across; ++s) {
        const std::size_t first = along_u ? table.patch(0, s) : table.patch(s, 0);
        const std::size_t last = along_u ? table.patch(table.u.spans() - 1, s) : table.patch(s, table.v.spans() - 1);
        for (std::size_t k = 0; k < row; ++k) {
            const auto corner = [&](std::size_t patch, bool end) {
                const std::size_t i = along_u ? (end ? nu - 1 : 0) : k, j = along_u ? k : (end ? nv - 1 : 0);
                const auto value = [&](std::size_t c) { return table.net(patch)[c * nu * nv + i * nv + j]; };
                const double w = table.rational() ? value(3) : 1.0;
                return Vec3(table.origins[patch] + Vec3(value(0), value(1), value(2)) / w);
            };
            if ((corner(first, false) - corner(last, true)).norm() > allowed) return false;
        }
    }
    return true;
}

}  // namespace

Result<Surface> Surface::bspline(BSplineData data) {
    if (auto ok = check_knots(data.knots_u, data.degree_u, data.count_u, 'u'); !ok) return fail_up(std::move(ok));
    if (auto ok = check_knots(data.knots_v, data.degree_v, data.count_v, 'v'); !ok) return fail_up(std::move(ok));
    if (data.control.size() != data.count_u * data.count_v)
        return fail(ErrorCode::invalid_input,
                    fmt::format("{} control points where {} x {} are needed", data.control.size(), data.count_u, data.count_v));
    if (!data.weights.empty() && data.weights.size() != data.control.size())
        return fail(ErrorCode::invalid_input,
                    fmt::format("{} weights for {} control points", data.weights.size(), data.control.size()));
    double size = 0.0;
    for (std::size_t k = 0; k < data.control.size(); ++k) {
        const auto where = [&] { return fmt::format("[{}][{}]", k / data.count_v, k % data.count_v); };
        if (!data.control[k].allFinite())
            return fail(ErrorCode::invalid_input, fmt::format("control point {} is not a number", where()));
        if (!data.weights.empty() && !(std::isfinite(data.weights[k]) && data.weights[k] > 0.0))
            return fail(ErrorCode::invalid_input,
                        fmt::format("weight {} is {}: weights must be positive", where(), data.weights[k]));
        size = std::max(size, data.control[k].norm());
    }
    // Equal weights are no weights: a polynomial is cheaper and its bounds are tighter.
    if (std::all_of(data.weights.begin(), data.weights.end(), [&](double w) { return w == data.weights.front(); }))
        data.weights.clear();

    auto spline = std::make_shared<Impl::Spline>();
    spline->patches = detail::make_patches(data);
    spline->bounds = detail::BoundTable(spline->patches);
    auto impl = std::make_shared<Impl>();
    impl->breaks_u = spline->patches.u.breaks();
    impl->breaks_v = spline->patches.v.breaks();
    impl->domain = {{impl->breaks_u.front(), impl->breaks_u.back()}, {impl->breaks_v.front(), impl->breaks_v.back()}};
    impl->domain.closed_u = ends_coincide(spline->patches, true, size);
    impl->domain.closed_v = ends_coincide(spline->patches, false, size);
    data.closed_u = impl->domain.closed_u;
    data.closed_v = impl->domain.closed_v;
    // 64 ulp of the surface's size, differenced over the shortest span.
    const auto noise = [&](const detail::SpanAxis& axis) {
        double shortest = 0.0;
        for (std::size_t s = 0; s < axis.spans(); ++s) shortest = std::max(shortest, axis.inverse_length(s));
        return 64.0 * kUlp * size * static_cast<double>(axis.degree()) * shortest;
    };
    impl->noise_u = noise(spline->patches.u);
    impl->noise_v = noise(spline->patches.v);
    spline->patches = detail::ready(std::move(spline->patches));
    spline->data = std::move(data);
    impl->spline = std::move(spline);
    return Surface(std::move(impl), 1.0);
}

Result<Surface> Surface::bezier(const std::vector<std::vector<Vec3>>& rows) {
    if (rows.size() < 2 || rows.front().size() < 2)
        return fail(ErrorCode::invalid_input, "a Bezier surface needs at least 2 x 2 control points");
    BSplineData data;
    data.count_u = rows.size();
    data.count_v = rows.front().size();
    data.degree_u = static_cast<int>(std::min<std::size_t>(data.count_u - 1, detail::kMaxDegree + 1));
    data.degree_v = static_cast<int>(std::min<std::size_t>(data.count_v - 1, detail::kMaxDegree + 1));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].size() != data.count_v)
            return fail(ErrorCode::invalid_input,
                        fmt::format("row {} has {} control points, the first has {}", i, rows[i].size(), data.count_v));
        data.control.insert(data.control.end(), rows[i].begin(), rows[i].end());
    }
    const auto clamped = [](std::size_t count) {
        std::vector<double> knots(2 * count, 0.0);
        std::fill(knots.begin() + static_cast<std::ptrdiff_t>(count), knots.end(), 1.0);
        return knots;
    };
    data.knots_u = clamped(data.count_u);
    data.knots_v = clamped(data.count_v);
    return bspline(std::move(data));
}

Result<Surface> Surface::analytic(const AnalyticData& data) {
    if (auto ok = detail::check_analytic(data); !ok) return fail_up(std::move(ok));
    auto impl = std::make_shared<Impl>();
    impl->analytic = data;
    impl->domain = detail::analytic_domain(data);
    impl->breaks_u = {impl->domain.u.lo, impl->domain.u.hi};
    impl->breaks_v = {impl->domain.v.lo, impl->domain.v.hi};
    const double size = std::abs(data.a) + std::abs(data.b) + std::abs(data.c);
    impl->noise_u = 64.0 * kUlp * size / std::min(1.0, impl->domain.u.length());
    impl->noise_v = 64.0 * kUlp * size / std::min(1.0, impl->domain.v.length());
    return Surface(std::move(impl), detail::analytic_sign(data));
}

const Domain& Surface::domain() const {
    return impl_->domain;
}
const std::vector<double>& Surface::breaks_u() const {
    return impl_->breaks_u;
}
const std::vector<double>& Surface::breaks_v() const {
    return impl_->breaks_v;
}
double Surface::normal_sign() const {
    return sign_;
}
Surface Surface::flipped() const {
    return Surface(impl_, -sign_);
}
const BSplineData* Surface::bspline_data() const {
    return impl_->spline ? &impl_->spline->data : nullptr;
}
const AnalyticData* Surface::analytic_data() const {
    return impl_->analytic ? &*impl_->analytic : nullptr;
}
std::string Surface::kind() const {
    return impl_->spline ? "bspline" : std::string(detail::name_of(impl_->analytic->kind));
}

namespace {
double clamped(double t, const Interval& range) {
    return t < range.lo ? range.lo : t > range.hi ? range.hi : t;
}
}  // namespace

void Surface::evaluate(std::span<const double> u, std::span<const double> v, int order, SurfaceBatch& out) const {
    TRUNNION_REQUIRE(u.size() == v.size());
    out.resize(u.size(), order);
    const Domain& d = impl_->domain;
    if (impl_->spline) {
        const auto& patches = impl_->spline->patches;
        const bool cut = d.u.lo > patches.u.breaks().front() || d.u.hi < patches.u.breaks().back() ||
                         d.v.lo > patches.v.breaks().front() || d.v.hi < patches.v.breaks().back();
        if (!cut) return detail::evaluate_patches(patches, u, v, order, out);
        std::vector<double> cu(u.size()), cv(v.size());
        for (std::size_t i = 0; i < u.size(); ++i) cu[i] = clamped(u[i], d.u), cv[i] = clamped(v[i], d.v);
        return detail::evaluate_patches(patches, cu, cv, order, out);
    }
    const int vectors = order == 0 ? 1 : order == 1 ? 3 : 6;
    for (std::size_t i = 0; i < u.size(); ++i) {
        const SurfacePoint p = detail::analytic_at(*impl_->analytic, clamped(u[i], d.u), clamped(v[i], d.v));
        const Vec3* all[6] = {&p.S, &p.Su, &p.Sv, &p.Suu, &p.Suv, &p.Svv};
        for (int k = 0; k < vectors; ++k)
            for (int c = 0; c < 3; ++c) out.plane(3 * k + c)[i] = (*all[k])[c];
    }
}

SurfacePoint Surface::at(double u, double v) const {
    const double cu = clamped(u, impl_->domain.u), cv = clamped(v, impl_->domain.v);
    return impl_->spline ? detail::evaluate_patch_at(impl_->spline->patches, cu, cv, 2)
                         : detail::analytic_at(*impl_->analytic, cu, cv);
}

Vec3 Surface::point(double u, double v) const {
    const double cu = clamped(u, impl_->domain.u), cv = clamped(v, impl_->domain.v);
    return impl_->spline ? detail::evaluate_patch_at(impl_->spline->patches, cu, cv, 0).S
                         : detail::analytic_at(*impl_->analytic, cu, cv).S;
}

std::optional<Vec3> Surface::normal(double u, double v) const {
    // S_u x S_v counts only where it stands above the rounding of its factors.
    const auto direction = [&](const Vec3& a, const Vec3& b) -> std::optional<Vec3> {
        const Vec3 cross = a.cross(b);
        const double length = cross.norm();
        if (!(length > 4.0 * (impl_->noise_u * b.norm() + impl_->noise_v * a.norm()))) return std::nullopt;
        return Vec3(sign_ * cross / length);
    };
    const Domain& d = impl_->domain;
    const double cu = clamped(u, d.u), cv = clamped(v, d.v);
    const SurfacePoint p = at(cu, cv);
    if (const auto n = direction(p.Su, p.Sv)) return n;
    // A pole, S_u = 0 along v = const: stepping inside by h, S_u = h S_uv + O(h^2), so that S_uv x S_v is the limit. Alike for
    // S_v.
    const double inward_u = cu <= d.u.mid() ? 1.0 : -1.0, inward_v = cv <= d.v.mid() ? 1.0 : -1.0;
    if (p.Su.norm() <= 4.0 * impl_->noise_u)
        if (const auto n = direction(inward_v * p.Suv, p.Sv)) return n;
    if (p.Sv.norm() <= 4.0 * impl_->noise_v)
        if (const auto n = direction(p.Su, inward_u * p.Suv)) return n;
    // Anything else (an edge tangent to its neighbour): the first clear direction further inside.
    for (double step = std::cbrt(kUlp); step < 0.01; step *= 8.0) {
        const SurfacePoint q = at(cu + inward_u * step * d.u.length(), cv + inward_v * step * d.v.length());
        if (const auto n = direction(q.Su, q.Sv)) return n;
    }
    return std::nullopt;
}

Result<Surface> Surface::restricted(const Interval& u, const Interval& v) const {
    const Domain& d = impl_->domain;
    const auto outside = [](const Interval& part, const Interval& whole) {
        return !(part.lo < part.hi) || part.lo < whole.lo || part.hi > whole.hi;  // also true for NaN
    };
    const auto bad = [](char axis, const Interval& part, const Interval& whole) {
        return fail(ErrorCode::invalid_input, fmt::format("{} from {} to {} is no part of the surface's range {} to {}", axis,
                                                          part.lo, part.hi, whole.lo, whole.hi));
    };
    if (outside(u, d.u)) return bad('u', u, d.u);
    if (outside(v, d.v)) return bad('v', v, d.v);
    auto impl = std::make_shared<Impl>(*impl_);
    impl->domain = {u, v, d.closed_u && u.lo == d.u.lo && u.hi == d.u.hi, d.closed_v && v.lo == d.v.lo && v.hi == d.v.hi};
    const auto cut = [](std::vector<double>& breaks, const Interval& range) {
        std::erase_if(breaks, [&](double b) { return b <= range.lo || b >= range.hi; });
        breaks.insert(breaks.begin(), range.lo);
        breaks.push_back(range.hi);
    };
    cut(impl->breaks_u, u);
    cut(impl->breaks_v, v);
    return Surface(std::move(impl), sign_);
}

SecondDerivativeBound Surface::second_derivative_bound(const Interval& u, const Interval& v) const {
    const auto sorted = [](const Interval& box, const Interval& range) {
        return Interval{clamped(std::min(box.lo, box.hi), range), clamped(std::max(box.lo, box.hi), range)};
    };
    const Interval cu = sorted(u, impl_->domain.u), cv = sorted(v, impl_->domain.v);
    return impl_->spline ? impl_->spline->bounds.over(impl_->spline->patches, cu, cv)
                         : detail::analytic_bound(*impl_->analytic, cu, cv);
}

NormalCurvatures curvatures(const SurfacePoint& p, const Vec3& n, const Vec3& f, const Vec3& b) {
    // First fundamental form: a tangent vector t = x S_u + y S_v has (x, y) from [E F; F G] (x, y) = (t.S_u, t.S_v).
    const double E = p.Su.dot(p.Su), F = p.Su.dot(p.Sv), G = p.Sv.dot(p.Sv), det = E * G - F * F;
    TRUNNION_REQUIRE(det > 0.0);
    const auto solve = [&](const Vec3& t) {
        const double tu = t.dot(p.Su), tv = t.dot(p.Sv);
        return Vec2((G * tu - F * tv) / det, (E * tv - F * tu) / det);
    };
    // Second fundamental form with the outward normal: positive where the surface bends towards it, i.e. concave.
    const double L = p.Suu.dot(n), M = p.Suv.dot(n), N = p.Svv.dot(n);
    const auto second = [&](const Vec2& s, const Vec2& t) {
        return L * s.x() * t.x() + M * (s.x() * t.y() + s.y() * t.x()) + N * s.y() * t.y();
    };
    const Vec2 along = solve(f), across = solve(b);
    return {second(along, along), second(along, across), second(across, across)};
}

}  // namespace trunnion
