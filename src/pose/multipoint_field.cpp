#include "pose/multipoint_field.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::detail {

namespace {

constexpr int kPowerDegree = 5;  ///< up to here powers of the centred parameter lose at most (1 + sqrt 2)^degree ulp of a span
constexpr std::size_t kStride = 4;
constexpr int kDeepest = 6;      ///< levels of the fixed tree of boxes
constexpr int kMostCells = 512;  ///< samples along one span

/// Blossom of one knot span at `arguments`: with a and b, the ends of any part of it, these are its Bezier points.
Vec3 blossom(const std::vector<double>& knots, int p, std::size_t k, const std::vector<double>& arguments, std::vector<Vec3> d) {
    for (int r = 1; r <= p; ++r)
        for (int i = p; i >= r; --i) {
            const std::size_t low = k - static_cast<std::size_t>(p - i), high = k + 1 + static_cast<std::size_t>(i - r);
            const double t = arguments[static_cast<std::size_t>(r - 1)];
            const double alpha = (t - knots[low]) / (knots[high] - knots[low]);
            d[static_cast<std::size_t>(i)] =
                (1.0 - alpha) * d[static_cast<std::size_t>(i - 1)] + alpha * d[static_cast<std::size_t>(i)];
        }
    return d[static_cast<std::size_t>(p)];
}

std::vector<Vec3> bezier_points(const std::vector<double>& knots, int p, const Interval& part, const std::vector<Vec3>& control) {
    std::size_t k = static_cast<std::size_t>(p);
    while (k + 2 + static_cast<std::size_t>(p) < knots.size() && knots[k + 1] <= part.lo) ++k;
    const std::vector<Vec3> local(control.begin() + static_cast<std::ptrdiff_t>(k) - p,
                                  control.begin() + static_cast<std::ptrdiff_t>(k) + 1);
    std::vector<Vec3> points;
    for (int j = 0; j <= p; ++j) {
        std::vector<double> arguments(static_cast<std::size_t>(p), part.lo);
        std::fill(arguments.end() - j, arguments.end(), part.hi);
        points.push_back(blossom(knots, p, k, arguments, local));
    }
    return points;
}

/// Power coefficients in x in [-1, 1] of Bezier points.
std::vector<Vec3> powers_of(const std::vector<Vec3>& bezier) {
    const std::size_t n = bezier.size() - 1;
    std::vector<Vec3> c(n + 1, Vec3::Zero());
    double choose = std::ldexp(1.0, -static_cast<int>(n));
    for (std::size_t i = 0; i <= n; ++i) {
        std::vector<double> polynomial{choose};  // C(n, i) (1 + x)^i (1 - x)^(n - i) / 2^n
        for (std::size_t k = 0; k < n; ++k) {
            polynomial.push_back(0.0);
            for (std::size_t j = polynomial.size() - 1; j > 0; --j) polynomial[j] += (k < i ? 1.0 : -1.0) * polynomial[j - 1];
        }
        for (std::size_t k = 0; k <= n; ++k) c[k] += polynomial[k] * bezier[i];
        choose *= static_cast<double>(n - i) / static_cast<double>(i + 1);
    }
    return c;
}

/// Value and derivatives in x and y of a polynomial with coefficients [i][j][4].
template <int kOrder>
void evaluate(const double* c, int nu, int nv, double x, double y, Eigen::Array4d* out) {
    using Four = Eigen::Array4d;
    using In = Eigen::Map<const Four>;
    Four f = Four::Zero(), fx = f, fy = f, fxx = f, fxy = f, fyy = f;
    for (int i = nu; i >= 0; --i) {
        const double* row = c + static_cast<std::size_t>(i * (nv + 1)) * kStride;
        Four q = In(row + static_cast<std::size_t>(nv) * kStride), q1 = Four::Zero(), q2 = Four::Zero();
        for (int j = nv - 1; j >= 0; --j) {
            if constexpr (kOrder > 1) q2 = q2 * y + q1;
            if constexpr (kOrder > 0) q1 = q1 * y + q;
            q = q * y + In(row + static_cast<std::size_t>(j) * kStride);
        }
        if constexpr (kOrder > 1) {
            fxx = fxx * x + fx;
            fxy = fxy * x + fy;
            fyy = fyy * x + 2.0 * q2;
        }
        if constexpr (kOrder > 0) {
            fx = fx * x + f;
            fy = fy * x + q1;
        }
        f = f * x + q;
    }
    out[0] = f;
    if constexpr (kOrder > 0) out[1] = fx, out[2] = fy;
    if constexpr (kOrder > 1) out[3] = 2.0 * fxx, out[4] = fxy, out[5] = fyy;
}

SurfacePoint scaled(const Eigen::Array4d* d, double ku, double kv) {
    const auto vec = [](const Eigen::Array4d& a) { return Vec3(a[0], a[1], a[2]); };
    return {vec(d[0]), ku * vec(d[1]), kv * vec(d[2]), ku * ku * vec(d[3]), ku * kv * vec(d[4]), kv * kv * vec(d[5])};
}

/// Coefficients about (x, y) with half sizes hx, hy: p(x + hx s, y + hy t) in powers of s and t.
void shift_to(const double* c, int nu, int nv, double x, double y, double hx, double hy, double* out) {
    using Four = Eigen::Array4d;
    const int width = nv + 1;
    std::copy_n(c, static_cast<std::size_t>((nu + 1) * width) * kStride, out);
    const auto at = [&](int i, int j) { return Eigen::Map<Four>(out + static_cast<std::size_t>(i * width + j) * kStride); };
    // Taylor shift by repeated synthetic division, along v then along u.
    for (int i = 0; i <= nu; ++i)
        for (int k = 0; k < nv; ++k)
            for (int j = nv - 1; j >= k; --j) at(i, j) += y * at(i, j + 1);
    for (int j = 0; j <= nv; ++j)
        for (int k = 0; k < nu; ++k)
            for (int i = nu - 1; i >= k; --i) at(i, j) += x * at(i + 1, j);
    double sx = 1.0;
    for (int i = 0; i <= nu; ++i, sx *= hx) {
        double s = sx;
        for (int j = 0; j <= nv; ++j, s *= hy) at(i, j) *= s;
    }
}

}  // namespace

Field::Field(const Surface& surface, std::shared_ptr<const Trim> trim, int face, const Interval& block_u, const Interval& block_v,
             double spacing)
    : surface_(surface), trim_(std::move(trim)), face_(face), u_(block_u), v_(block_v) {
    const auto cut = [](const std::vector<double>& breaks, const Interval& range) {
        std::vector<double> inside{range.lo};
        for (const double b : breaks)
            if (b > range.lo && b < range.hi) inside.push_back(b);
        inside.push_back(range.hi);
        return inside;
    };
    breaks_u_ = cut(surface.breaks_u(), u_);
    breaks_v_ = cut(surface.breaks_v(), v_);
    const BSplineData* data = surface.bspline_data();
    polynomial_ = data && data->weights.empty() && data->degree_u <= kPowerDegree && data->degree_v <= kPowerDegree;
    if (!data) {
        // Analytic surfaces come as one span; bounds of parts of it are much better than of all of it.
        const auto refine = [](std::vector<double>& breaks) {
            constexpr int kPieces = 4;
            const double lo = breaks.front(), hi = breaks.back();
            breaks.clear();
            for (int k = 0; k <= kPieces; ++k) breaks.push_back(k == kPieces ? hi : lo + (hi - lo) * k / kPieces);
        };
        refine(breaks_u_);
        refine(breaks_v_);
    }
    make_spans(spacing);
}

void Field::make_spans(double spacing) {
    const BSplineData* data = surface_.bspline_data();
    const std::size_t count_u = breaks_u_.size() - 1, count_v = breaks_v_.size() - 1;
    if (data) nu_ = data->degree_u, nv_ = data->degree_v;
    std::vector<int> cells_u(count_u, 1), cells_v(count_v, 1);
    for (std::size_t i = 0; i < count_u; ++i)
        for (std::size_t j = 0; j < count_v; ++j) {
            Span s;
            s.u = {breaks_u_[i], breaks_u_[i + 1]};
            s.v = {breaks_v_[j], breaks_v_[j + 1]};
            s.cu = s.u.mid(), s.cv = s.v.mid();
            s.inverse_u = 2.0 / s.u.length(), s.inverse_v = 2.0 / s.v.length();
            if (polynomial_) {
                s.coefficients = coefficients_.size();
                std::vector<std::vector<Vec3>> rows;  // per control row along u: Bezier points in v
                for (std::size_t r = 0; r < data->count_u; ++r)
                    rows.push_back(bezier_points(data->knots_v, nv_, s.v,
                                                 {data->control.begin() + static_cast<std::ptrdiff_t>(r * data->count_v),
                                                  data->control.begin() + static_cast<std::ptrdiff_t>((r + 1) * data->count_v)}));
                std::vector<std::vector<Vec3>> columns;  // [j][i] in powers of x
                for (int k = 0; k <= nv_; ++k) {
                    std::vector<Vec3> column;
                    for (const auto& row : rows) column.push_back(row[static_cast<std::size_t>(k)]);
                    columns.push_back(powers_of(bezier_points(data->knots_u, nu_, s.u, column)));
                }
                for (int r = 0; r <= nu_; ++r) {
                    std::vector<Vec3> row;
                    for (const auto& column : columns) row.push_back(column[static_cast<std::size_t>(r)]);
                    for (const Vec3& c : powers_of(row)) coefficients_.insert(coefficients_.end(), {c.x(), c.y(), c.z(), 0.0});
                }
            }
            spans_.push_back(s);
            // Lengths by nine samples a side: they decide densities only.
            double along_u = 0.0, along_v = 0.0;
            constexpr int kSide = 4;
            Vec3 grid[kSide + 1][kSide + 1];
            for (int a = 0; a <= kSide; ++a)
                for (int b = 0; b <= kSide; ++b)
                    grid[a][b] = surface_.point(s.u.at(a / double(kSide)), s.v.at(b / double(kSide)));
            for (int b = 0; b <= kSide; ++b) {
                double lu = 0.0, lv = 0.0;
                for (int a = 0; a < kSide; ++a)
                    lu += (grid[a + 1][b] - grid[a][b]).norm(), lv += (grid[b][a + 1] - grid[b][a]).norm();
                along_u = std::max(along_u, lu);
                along_v = std::max(along_v, lv);
            }
            const auto cells = [&](double length) {
                return std::clamp(static_cast<int>(std::ceil(length / spacing)), 2, kMostCells);
            };
            cells_u[i] = std::max(cells_u[i], cells(along_u));
            cells_v[j] = std::max(cells_v[j], cells(along_v));
            const double wanted = std::max(along_u, along_v) / (2.0 * spacing);
            spans_.back().depth = std::clamp(static_cast<int>(std::ceil(std::log2(std::max(1.0, wanted)))), 0, kDeepest);
        }
    const auto lattice = [](const std::vector<double>& breaks, const std::vector<int>& cells) {
        std::vector<double> p;
        for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
            for (int k = 0; k < cells[i]; ++k) p.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * k / cells[i]);
        p.push_back(breaks.back());
        return p;
    };
    lattice_u = lattice(breaks_u_, cells_u);
    lattice_v = lattice(breaks_v_, cells_v);

    for (Span& s : spans_) {
        s.first_node = nodes_.size();
        for (int level = 0; level <= s.depth; ++level) {
            // Level order: the children of node i are 4 i + 1 ... 4 i + 4, so the path to a node is its index.
            const std::int64_t first = ((std::int64_t{1} << (2 * level)) - 1) / 3, count = std::int64_t{1} << (2 * level);
            for (std::int64_t k = 0; k < count; ++k) {
                double x = 0.0, y = 0.0, h = 1.0;
                for (int d = level - 1; d >= 0; --d) {
                    const int child = static_cast<int>((k >> (2 * d)) & 3);
                    h *= 0.5;
                    x += (child & 1) ? h : -h;
                    y += (child & 2) ? h : -h;
                }
                (void)first;
                nodes_.push_back(polynomial_ ? shifted(s, x, y, h) : bounded(s, x, y, h));
            }
        }
    }
}

std::size_t Field::locate(double u, double v) const {
    const auto find = [](const std::vector<double>& breaks, double t) {
        if (breaks.size() == 2) return std::size_t{0};
        const auto it = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t);
        return static_cast<std::size_t>(it - breaks.begin()) - 1;
    };
    return find(breaks_u_, u) * (breaks_v_.size() - 1) + find(breaks_v_, v);
}

SurfacePoint Field::at(double u, double v) const {
    if (!polynomial_) return surface_.at(u, v);
    const Span& s = spans_[locate(u, v)];
    Eigen::Array4d d[6];
    evaluate<2>(coefficients_.data() + s.coefficients, nu_, nv_, (u - s.cu) * s.inverse_u, (v - s.cv) * s.inverse_v, d);
    return scaled(d, s.inverse_u, s.inverse_v);
}

void Field::append_tiles(std::uint32_t index, std::vector<Tile>& tiles) const {
    constexpr int kInner = Tile::kSide - 2;
    const int nu = static_cast<int>(lattice_u.size()), nv = static_cast<int>(lattice_v.size());
    std::vector<double> u, v;
    SurfaceBatch batch;
    for (int i = 0; i < nu; i += kInner) {
        for (int j = 0; j < nv; j += kInner) {
            u.clear();
            v.clear();
            for (int a = i - 1; a < i - 1 + Tile::kSide; ++a)
                for (int b = j - 1; b < j - 1 + Tile::kSide; ++b) {
                    u.push_back(lattice_u[static_cast<std::size_t>(std::clamp(a, 0, nu - 1))]);
                    v.push_back(lattice_v[static_cast<std::size_t>(std::clamp(b, 0, nv - 1))]);
                }
            surface_.evaluate(u, v, 0, batch);
            Tile tile;
            tile.x.fill(Tile::kFar), tile.y.fill(Tile::kFar), tile.z.fill(-Tile::kFar);
            tile.field = index;
            tile.first_u = i;
            tile.first_v = j;
            Box3 box;
            for (int k = 0; k < Tile::kSize; ++k) {
                const int a = i - 1 + k / Tile::kSide, b = j - 1 + k % Tile::kSide;
                const auto at = static_cast<std::size_t>(k);
                const bool in = a >= 0 && a < nu && b >= 0 && b < nv && (!trimmed() || inside(u[at], v[at]));
                tile.x[at] = in ? batch.plane(0)[k] : Tile::kFar;
                tile.y[at] = in ? batch.plane(1)[k] : Tile::kFar;
                tile.z[at] = in ? batch.plane(2)[k] : -Tile::kFar;
                if (in) box.add(batch.point(at));
            }
            if (box.empty()) continue;
            tile.centre = box.centre();
            tile.radius = box.half().norm();
            tiles.push_back(tile);
        }
    }
}

TaylorBox Field::shifted(const Span& span, double x, double y, double h) const {
    double c[36 * kStride];
    shift_to(coefficients_.data() + span.coefficients, nu_, nv_, x, y, h, h, c);
    using Four = Eigen::Array4d;
    const auto at = [&](int i, int j) {
        return Eigen::Map<const Four>(c + static_cast<std::size_t>(i * (nv_ + 1) + j) * kStride);
    };
    const auto vec = [](const Four& a) { return Vec3(a[0], a[1], a[2]); };
    // Even powers range over [0, 1]: half of each goes into the centre, half into the remainder.
    Four shift = Four::Zero(), rem = Four::Zero();
    for (int i = 0; i <= nu_; ++i)
        for (int j = 0; j <= nv_; ++j) {
            if (i + j < 2) continue;
            if (i % 2 == 0 && j % 2 == 0) {
                shift += 0.5 * at(i, j);
                rem += 0.5 * at(i, j).abs();
            } else {
                rem += at(i, j).abs();
            }
        }
    TaylorBox box{vec(at(0, 0)), vec(shift), vec(at(1, 0)), vec(at(0, 1)), vec(rem), 0.0};
    box.rem_norm = box.rem.norm();
    return box;
}

TaylorBox Field::bounded(const Span& span, double x, double y, double h) const {
    const double hu = h / span.inverse_u, hv = h / span.inverse_v;
    const double u = span.cu + x / span.inverse_u, v = span.cv + y / span.inverse_v;
    const SurfacePoint p = surface_.at(u, v);
    const SecondDerivativeBound bound = surface_.second_derivative_bound({u - hu, u + hu}, {v - hv, v + hv});
    const double r =
        0.5 * (bound.uu * hu * hu + 2.0 * bound.uv * hu * hv + bound.vv * hv * hv) + bound.kink_u * hu + bound.kink_v * hv;
    return {p.S, Vec3::Zero(), hu * p.Su, hv * p.Sv, Vec3::Constant(r), r};
}

TaylorBox Field::taylor(const SpanBox& box) const {
    const Span& span = spans_[box.span];
    if (box.node >= 0) return nodes_[span.first_node + static_cast<std::size_t>(box.node)];
    return polynomial_ ? shifted(span, box.x, box.y, box.h) : bounded(span, box.x, box.y, box.h);
}

std::array<SpanBox, 4> Field::children(const SpanBox& box) const {
    const Span& span = spans_[box.span];
    const std::int64_t nodes = ((std::int64_t{1} << (2 * (span.depth + 1))) - 1) / 3;
    std::array<SpanBox, 4> four;
    for (int k = 0; k < 4; ++k) {
        SpanBox& child = four[static_cast<std::size_t>(k)];
        child = box;
        child.h = 0.5 * box.h;
        child.x += (k & 1) ? child.h : -child.h;
        child.y += (k & 2) ? child.h : -child.h;
        child.node = box.node >= 0 && 4 * box.node + 1 + k < nodes ? 4 * box.node + 1 + k : -1;
    }
    return four;
}

Box3 Field::span_box(std::size_t span) const {
    const TaylorBox& t = root(span);
    const Vec3 reach = t.a.cwiseAbs() + t.e.cwiseAbs() + t.rem, centre = t.s + t.shift;
    Box3 box;
    box.add(centre - reach);
    box.add(centre + reach);
    return box;
}

Vec2 Field::parameters(const SpanBox& box) const {
    const Span& s = spans_[box.span];
    return {std::clamp(s.cu + box.x / s.inverse_u, u_.lo, u_.hi), std::clamp(s.cv + box.y / s.inverse_v, v_.lo, v_.hi)};
}

Vec2 Field::half_sizes(const SpanBox& box) const {
    const Span& s = spans_[box.span];
    return {box.h / s.inverse_u, box.h / s.inverse_v};
}

Field::Near::Near(const Field& field, double u, double v, const std::optional<Vec3>& n) : field_(field), u_(u), v_(v) {
    origin_ = field.at(u, v).S;
    if (!field.polynomial_) return;
    span_ = field.locate(u, v);
    const Span& s = field.spans_[*span_];
    nu_ = field.nu_, nv_ = field.nv_;
    scale_u_ = s.inverse_u, scale_v_ = s.inverse_v;
    shift_to(field.coefficients_.data() + s.coefficients, nu_, nv_, (u - s.cu) * s.inverse_u, (v - s.cv) * s.inverse_v, 1.0, 1.0,
             c_.data());
    for (std::size_t k = 0; k < 3; ++k) c_[k] = 0.0;
    if (!n) return;
    for (const std::size_t first : {kStride, static_cast<std::size_t>(nv_ + 1) * kStride}) {
        double along = 0.0;
        for (std::size_t k = 0; k < 3; ++k) along += c_[first + k] * (*n)[static_cast<Eigen::Index>(k)];
        for (std::size_t k = 0; k < 3; ++k) c_[first + k] -= along * (*n)[static_cast<Eigen::Index>(k)];
    }
}

SurfacePoint Field::Near::at(double u, double v) const {
    if (span_ && field_.locate(u, v) == *span_) {
        Eigen::Array4d d[6];
        evaluate<2>(c_.data(), nu_, nv_, (u - u_) * scale_u_, (v - v_) * scale_v_, d);
        return scaled(d, scale_u_, scale_v_);
    }
    SurfacePoint p = field_.at(u, v);
    p.S -= origin_;
    return p;
}

std::vector<Field> fields_of(const Surface& surface, const Trim& trim, int face, double spacing) {
    // Creases: interior knots as often as the degree.
    const auto blocks = [&](const Interval& range, int degree, const std::vector<double>* knots) {
        std::vector<double> ends{range.lo};
        if (knots)
            for (std::size_t k = 0; k < knots->size();) {
                const auto times = std::count(knots->begin(), knots->end(), (*knots)[k]);
                if (times >= degree && (*knots)[k] > range.lo && (*knots)[k] < range.hi) ends.push_back((*knots)[k]);
                k += static_cast<std::size_t>(times);
            }
        ends.push_back(range.hi);
        return ends;
    };
    const BSplineData* data = surface.bspline_data();
    const std::vector<double> u = blocks(surface.domain().u, data ? data->degree_u : 1, data ? &data->knots_u : nullptr);
    const std::vector<double> v = blocks(surface.domain().v, data ? data->degree_v : 1, data ? &data->knots_v : nullptr);
    const auto shared = std::make_shared<const Trim>(trim);
    std::vector<Field> fields;
    for (std::size_t i = 0; i + 1 < u.size(); ++i)
        for (std::size_t j = 0; j + 1 < v.size(); ++j)
            fields.emplace_back(surface, shared, face, Interval{u[i], u[i + 1]}, Interval{v[j], v[j + 1]}, spacing);
    return fields;
}

}  // namespace trunnion::detail
