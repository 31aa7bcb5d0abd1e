// From key axes to a field: what is wrong with them, the shape of the kernel, the system, the spline.
#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "orientation/field_impl.hpp"
#include "orientation/field_spline.hpp"
#include "orientation/sphere.hpp"

namespace trunnion {

using detail::FieldImpl;

std::string_view name_of(FieldDistance d) {
    constexpr std::array<std::string_view, 5> names{"auto", "chord", "param", "cylinder", "embedded-cylinder"};
    return names[static_cast<std::size_t>(d)];
}
std::string_view name_of(FieldMode m) {
    constexpr std::array<std::string_view, 4> names{"raw", "logmap", "karcher", "lean"};
    return names[static_cast<std::size_t>(m)];
}
std::string_view name_of(FieldTail t) {
    constexpr std::array<std::string_view, 5> names{"auto", "none", "constant", "linear", "linear-xyz"};
    return names[static_cast<std::size_t>(t)];
}

namespace {

constexpr double kLeastRcond = 1e-13, kPoorRcond = 1e-10, kShapeRcond = 1e-12;
constexpr std::size_t kMostDense = 8000;

tl::unexpected<Error> bad(std::string message) {
    return fail(ErrorCode::invalid_input, "toff: " + std::move(message));
}

Result<void> check_keys_alone(const FieldImpl& f) {
    if (f.keys.empty()) return bad("no key axes given");
    for (std::size_t k = 0; k < f.keys.size(); ++k) {
        const FieldKey& key = f.keys[k];
        if (!key.uv.allFinite() || !key.axis.allFinite()) return bad(fmt::format("key {}: parameter or axis is not finite", k));
        constexpr double kZero = 1e-12;
        if (key.axis.norm() < kZero) return bad(fmt::format("key {}: axis has zero length", k));
        constexpr double kOutside = 1e-9;  // rounding of parameters that were given in another unit
        const bool in_u = key.uv.x() >= -kOutside && key.uv.x() <= 1.0 + kOutside;
        const bool in_v = f.options.half_open || (key.uv.y() >= -kOutside && key.uv.y() <= 1.0 + kOutside);
        if (!in_u || !in_v) {
            const Vec2 native = f.surface.to_native(key.uv);
            const Vec2 lo = f.surface.to_native({0.0, 0.0}), hi = f.surface.to_native({1.0, 1.0});
            return bad(
                fmt::format("key {}: u {:.6g} v {:.6g} lies outside the surface, which has u from {:.6g} to {:.6g} and v from "
                            "{:.6g} to {:.6g}",
                            k, native.x(), native.y(), lo.x(), hi.x(), lo.y(), hi.y()));
        }
    }
    return {};
}

void resolve_distance(FieldImpl& f) {
    FieldOptions& o = f.options;
    if (o.distance == FieldDistance::automatic)
        o.distance = !o.half_open         ? FieldDistance::chord
                     : o.kernel.compact() ? FieldDistance::cylinder
                                          : FieldDistance::embedded_cylinder;
    if (o.tail == FieldTail::automatic) o.tail = o.mode == FieldMode::raw ? FieldTail::none : FieldTail::constant;
    if (o.half_open && !(o.q > 0.0)) o.q = f.surface.cylinder_ratio();
    Box3 box;
    std::vector<double> u, v;
    for (const FieldKey& key : f.keys) u.push_back(key.uv.x()), v.push_back(key.uv.y());
    if (!f.needs_surface()) return;
    SurfaceBatch batch;
    f.surface.evaluate(u, v, 0, batch);
    for (std::size_t k = 0; k < u.size(); ++k) box.add(batch.point(k));
    f.tail_centre = box.centre();
    f.tail_scale = box.diagonal() > 0.0 ? 1.0 / box.diagonal() : 1.0;
    if (!(o.scale > 0.0)) o.scale = f.tail_scale;
}

void place_keys(FieldImpl& f) {
    std::vector<double> u, v;
    for (const FieldKey& key : f.keys) u.push_back(key.uv.x()), v.push_back(key.uv.y());
    detail::FeaturePoints points;
    f.features(u, v, 0, points);
    f.sum.keys = std::move(points.x);
    f.sum.space = f.space();
}

double largest_extent(const FieldImpl& f) {
    double square = 0.0;
    for (const auto& x : f.sum.keys.x) {
        const auto [lo, hi] = std::minmax_element(x.begin(), x.end());
        square += (*hi - *lo) * (*hi - *lo);
    }
    return std::sqrt(square);
}

/// Pairs of keys at most `limit` apart, ordered. A sweep over the first coordinate that is not wrapped.
std::vector<std::array<std::size_t, 2>> near_pairs(const FieldImpl& f, double limit) {
    std::vector<std::size_t> order(f.keys.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto& x = f.sum.keys.x[0];
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
    std::vector<std::array<std::size_t, 2>> pairs;
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::size_t j = i + 1; j < order.size() && x[order[j]] - x[order[i]] <= limit; ++j)
            if (detail::feature_distance(f, order[i], order[j]) <= limit)
                pairs.push_back({std::min(order[i], order[j]), std::max(order[i], order[j])});
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

/// Keys at one point: one stays where their axes agree, else it is an error. `names[i]`: the number of key i in the input.
Result<void> merge_keys(FieldImpl& f, std::vector<std::size_t>& names) {
    constexpr double kSame = 1e-9;
    const double sameAngle = radians(0.01);
    std::vector<std::uint8_t> gone(f.keys.size(), 0);
    for (const auto& [a, b] : near_pairs(f, kSame * largest_extent(f))) {
        if (gone[a] || gone[b]) continue;
        const double angle = angle_between(f.keys[a].axis, f.keys[b].axis);
        if (angle > sameAngle)
            return bad(fmt::format("keys {} and {} lie at the same point (distance {:.3g}) but their axes differ by {:.3f} deg",
                                   a, b, detail::feature_distance(f, a, b), degrees(angle)));
        gone[b] = 1;
        f.report.warnings.push_back(
            fmt::format("toff: key {} merged into key {} (same point, axes differ by {:.3g} deg)", b, a, degrees(angle)));
        ++f.report.merged;
    }
    std::vector<FieldKey> kept;
    for (std::size_t k = 0; k < f.keys.size(); ++k)
        if (!gone[k]) kept.push_back(f.keys[k]), names.push_back(k);
    f.keys = std::move(kept);
    if (f.report.merged > 0) place_keys(f);
    return {};
}

Result<void> check_axes(FieldImpl& f, const std::vector<std::size_t>& names) {
    for (std::size_t k = 0; k < f.keys.size(); ++k) {
        const auto n = f.surface.normal(f.keys[k].uv.x(), f.keys[k].uv.y());
        const double angle = n ? angle_between(*n, f.keys[k].axis) : 0.0;  // at a pole there is no normal to compare with
        if (angle > f.options.normal_limit)
            return bad(fmt::format("key {}: axis is {:.3f} deg from the outward normal, limit {:.3f} deg", names[k],
                                   degrees(angle), degrees(f.options.normal_limit)));
    }
    if (f.keys.size() <= kMostDense) {
        double least = 1.0;
        std::array<std::size_t, 2> pair{0, 0};
        for (std::size_t a = 0; a < f.keys.size(); ++a)
            for (std::size_t b = a + 1; b < f.keys.size(); ++b)
                if (const double cosine = f.keys[a].axis.dot(f.keys[b].axis); cosine < least) least = cosine, pair = {a, b};
        const double angle = angle_between(f.keys[pair[0]].axis, f.keys[pair[1]].axis);
        if (angle > radians(170.0))
            f.report.warnings.push_back(fmt::format("toff: keys {} and {} have nearly opposite axes ({:.3f} deg)", names[pair[0]],
                                                    names[pair[1]], degrees(angle)));
    }
    return {};
}

/// Edges of the parameter square that are one point in space, where keys with different axes ask for a field of many values.
void check_edges(FieldImpl& f) {
    constexpr int kSamples = 17;
    std::vector<double> u, v;
    for (int edge = 0; edge < 4; ++edge)
        for (int i = 0; i < kSamples; ++i) {
            const double t = static_cast<double>(i) / (kSamples - 1), side = edge % 2;
            u.push_back(edge < 2 ? side : t);
            v.push_back(edge < 2 ? t : side);
        }
    SurfaceBatch batch;
    f.surface.evaluate(u, v, 0, batch);
    Box3 whole;
    for (std::size_t i = 0; i < u.size(); ++i) whole.add(batch.point(i));
    constexpr double kCollapsed = 1e-9, kOnEdge = 1e-9;
    constexpr std::array<std::string_view, 4> names{"u=0", "u=1", "v=0", "v=1"};
    for (std::size_t edge = 0; edge < (f.options.half_open ? 2U : 4U); ++edge) {
        Box3 box;
        for (std::size_t i = 0; i < kSamples; ++i) box.add(batch.point(edge * kSamples + i));
        if (box.diagonal() > kCollapsed * whole.diagonal()) continue;
        std::vector<const FieldKey*> on;
        for (const FieldKey& key : f.keys)
            if (std::abs((edge < 2 ? key.uv.x() : key.uv.y()) - static_cast<double>(edge % 2)) <= kOnEdge) on.push_back(&key);
        double spread = 0.0;
        for (std::size_t a = 0; a < on.size(); ++a)
            for (std::size_t b = a + 1; b < on.size(); ++b) spread = std::max(spread, angle_between(on[a]->axis, on[b]->axis));
        if (degrees(spread) > 0.5)
            f.report.warnings.push_back(fmt::format("toff: edge {} collapses to a point but its key axes spread over {:.3f} deg",
                                                    names[edge], degrees(spread)));
    }
}

/// Largest distance of a point of the surface from its nearest key, on a 41 x 41 grid.
double fill_distance(const FieldImpl& f) {
    constexpr int kSide = 41;
    std::vector<double> u, v;
    for (int i = 0; i < kSide; ++i)
        for (int j = 0; j < kSide; ++j)
            u.push_back(i / (kSide - 1.0)), v.push_back(f.options.half_open ? j / static_cast<double>(kSide) : j / (kSide - 1.0));
    detail::FeaturePoints points;
    f.features(u, v, 0, points);
    double most = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < f.keys.size(); ++k) {
            double square = 0.0;
            for (std::size_t d = 0; d < 3; ++d) {
                double away = points.x.x[d][i] - f.sum.keys.x[d][k];
                if (d == 1 && f.sum.space == detail::SumSpace::wrapped) away -= std::nearbyint(away);
                square += away * away;
            }
            least = std::min(least, square);
        }
        most = std::max(most, least);
    }
    return std::sqrt(most);
}

/// Kernels on distances that come from a Euclidean space are positive definite; on the wrapped cylinder only the compact ones
/// are.
bool definite(const FieldImpl& f) {
    return f.options.distance != FieldDistance::cylinder || f.options.kernel.compact();
}

/// Root mean square of the leave-one-out errors e_k = c_k / (K^-1)_kk, or infinity where the system is too ill-conditioned.
double loo_error(const FieldImpl& f, const Kernel& kernel, double ridge, const Eigen::MatrixXd& values) {
    const auto system = detail::KeySystem::factor(detail::key_matrix(f, kernel, ridge), detail::tail_matrix(f), definite(f));
    if (!system || system->rcond() < kShapeRcond) return std::numeric_limits<double>::infinity();
    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(system->keys() + system->tail(), values.cols());
    rhs.topRows(values.rows()) = values;
    const Eigen::MatrixXd c = system->solve(rhs);
    const Eigen::VectorXd d = system->inverse_diagonal();
    double sum = 0.0;
    for (Eigen::Index k = 0; k < d.size(); ++k) sum += (c.row(k) / d[k]).squaredNorm();
    const double rms = std::sqrt(sum / static_cast<double>(d.size()));
    return std::isfinite(rms) ? rms : std::numeric_limits<double>::infinity();
}

/// Least value over [lo, hi] on a log scale: 41 samples, then golden section between the neighbours of the best.
template <class F>
std::pair<double, double> least_on_log(double lo, double hi, F&& error) {
    constexpr int kSamples = 41, kRounds = 40;
    const double step = std::log(hi / lo) / (kSamples - 1);
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kSamples; ++k)
        if (const double e = error(lo * std::exp(step * k)); e < least) least = e, best = k;
    double a = std::log(lo) + step * std::max(0, best - 1), b = std::log(lo) + step * std::min(kSamples - 1, best + 1);
    double at = lo * std::exp(step * best);
    constexpr double kGolden = 0.6180339887498949;
    double x1 = b - kGolden * (b - a), x2 = a + kGolden * (b - a), e1 = error(std::exp(x1)), e2 = error(std::exp(x2));
    for (int k = 0; k < kRounds; ++k) {
        if (e1 < e2) {
            b = x2, x2 = x1, e2 = e1;
            x1 = b - kGolden * (b - a), e1 = error(std::exp(x1));
        } else {
            a = x1, x1 = x2, e1 = e2;
            x2 = a + kGolden * (b - a), e2 = error(std::exp(x2));
        }
        if (std::min(e1, e2) < least) least = std::min(e1, e2), at = std::exp(e1 < e2 ? x1 : x2);
    }
    return {at, least};
}

Result<void> resolve_kernel(FieldImpl& f, const Eigen::MatrixXd& values) {
    Kernel& k = f.options.kernel;
    const bool wrapped = f.options.distance == FieldDistance::cylinder;
    const double extent = std::max(largest_extent(f), 1e-300);
    if (f.options.auto_shape) {
        // From a twentieth of the keys' extent to ten times it, as half widths: beyond, the matrix is the identity or singular.
        Kernel low = k.with_half_width(0.05 * extent), high = k.with_half_width(10.0 * extent);
        if (low.shape() > high.shape()) std::swap(low, high);
        if (wrapped && k.compact()) high.shape() = std::min(high.shape(), 0.5), low.shape() = std::min(low.shape(), 0.05);
        const auto [shape, error] = least_on_log(low.shape(), high.shape(), [&](double s) {
            Kernel trial = k;
            trial.shape() = s;
            return loo_error(f, trial, f.options.ridge, values);
        });
        if (!std::isfinite(error))
            return bad("no shape of the kernel gives a well-conditioned key matrix; give shape, or spread the keys");
        k.shape() = shape;
        f.report.loo = error;
    } else if (k.shape() == 0.0) {
        // Twice the fill distance: above the rule of thumb of 1.5, below which the vector between keys gets short.
        const double half = f.report.fill_distance > 0.0 ? 2.0 * f.report.fill_distance : 1.0;
        k = k.with_half_width(half);
        if (wrapped && k.compact()) k.a = std::min(k.a, 0.5);
    }
    if (auto ok = check_kernel(k, wrapped); !ok) return ok;
    if (f.options.auto_ridge) {
        const auto [ridge, error] = least_on_log(1e-14, 1.0, [&](double r) { return loo_error(f, k, r, values); });
        if (!std::isfinite(error)) return bad("no ridge gives a well-conditioned key matrix; spread the keys");
        f.options.ridge = ridge;
        f.report.loo = error;
    }
    if (k.half_width() < f.report.fill_distance)
        f.report.warnings.push_back(fmt::format(
            "toff: the kernel's half width {:.3g} is less than the fill distance {:.3g}: between keys the field rests on "
            "little; widen the kernel or add keys",
            k.half_width(), f.report.fill_distance));
    return {};
}

Result<void> solve(FieldImpl& f, const Eigen::MatrixXd& values, const std::vector<std::size_t>& names) {
    const FieldOptions& o = f.options;
    const Eigen::MatrixXd A = detail::key_matrix(f, o.kernel, o.ridge), P = detail::tail_matrix(f);
    if (!definite(f))
        f.report.warnings.push_back(
            fmt::format("toff: the {} kernel may be indefinite on the wrapped cylinder; distance = "
                        "\"embedded-cylinder\" keeps it definite",
                        name_of(o.kernel.kind)));
    f.system = detail::KeySystem::factor(A, P, definite(f));
    f.report.rcond = f.system ? f.system->rcond() : 0.0;
    if (f.report.rcond < kLeastRcond) {
        const auto [a, b] = detail::closest_keys(f);
        return bad(fmt::format("key matrix is ill-conditioned (rcond {:.2e} < {:.0e}); closest keys {} and {}", f.report.rcond,
                               kLeastRcond, names[a], names[b]));
    }
    if (f.report.rcond < kPoorRcond)
        f.report.warnings.push_back(
            fmt::format("toff: key matrix is poorly conditioned (rcond {:.2e} < {:.0e})", f.report.rcond, kPoorRcond));
    const Eigen::Index M = values.rows(), m = P.cols();
    Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(M + m, 3);
    rhs.topRows(M) = values;
    Eigen::MatrixXd x = f.system->solve(rhs);
    const auto defect = [&] {
        Eigen::MatrixXd d(M + m, 3);
        d.topRows(M) = values - A * x.topRows(M) - P * x.bottomRows(m);
        d.bottomRows(m) = -P.transpose() * x.topRows(M);
        return d;
    };
    x += f.system->solve(defect());  // one step of refinement
    f.report.residual = defect().topRows(M).cwiseAbs().maxCoeff();
    constexpr double kMostResidual = 1e-9;
    if (!(f.report.residual <= kMostResidual)) {
        const auto [a, b] = detail::closest_keys(f);
        return bad(fmt::format("the key system was not solved (residual {:.2e} > {:.0e}); closest keys {} and {}",
                               f.report.residual, kMostResidual, names[a], names[b]));
    }
    f.sum.kernel = o.kernel;
    for (Eigen::Index d = 0; d < 3; ++d) f.sum.c[static_cast<std::size_t>(d)].assign(x.col(d).data(), x.col(d).data() + M);
    f.tail = x.bottomRows(m);
    if (o.mode != FieldMode::karcher) f.system.reset();  // only its weights need the factors again
    return {};
}

Result<void> add_spline(FieldImpl& f, const Control& control) {
    FieldOptions& o = f.options;
    if (!o.spline) return {};
    if (o.samples == FieldSamples::raw && o.mode != FieldMode::raw) return bad("samples = \"raw\" needs mode = \"raw\"");
    constexpr int kMostSamples = 2048;
    for (auto n = *o.spline;; n = {2 * n[0], 2 * n[1]}) {
        std::vector<double> u, v;
        const int count_v = o.half_open ? n[1] : n[1] + 1;
        for (int i = 0; i <= n[0]; ++i)
            for (int j = 0; j < count_v; ++j)
                u.push_back(static_cast<double>(i) / n[0]), v.push_back(static_cast<double>(j) / n[1]);
        FieldBatch batch;
        if (auto done = f.evaluate(u, v, 0, false, batch, control); !done) return done;
        auto spline =
            detail::spline_through(o.samples == FieldSamples::raw ? batch.raw : batch.unit, n, o.degree, o.knots, o.half_open);
        if (!spline) return fail_up(std::move(spline));
        f.spline = std::move(*spline);
        f.report.spline = n;
        if (!(o.spline_tolerance > 0.0)) return {};
        u.clear(), v.clear();
        for (const FieldKey& key : f.keys) u.push_back(key.uv.x()), v.push_back(key.uv.y());
        if (auto done = f.evaluate(u, v, 0, true, batch, control); !done) return done;
        double most = 0.0;
        for (std::size_t k = 0; k < f.keys.size(); ++k) most = std::max(most, angle_between(f.keys[k].axis, batch.unit[k]));
        if (most <= o.spline_tolerance) return {};
        if (std::max(n[0], n[1]) >= kMostSamples)
            return bad(
                fmt::format("the spline misses a key by {:.3g} deg with {} x {} samples, more than the {:.3g} deg asked for; "
                            "leave the spline out",
                            degrees(most), n[0], n[1], degrees(o.spline_tolerance)));
    }
}

}  // namespace

namespace detail {

double feature_distance(const FieldImpl& f, std::size_t a, std::size_t b) {
    double square = 0.0;
    for (std::size_t d = 0; d < 3; ++d) {
        double away = f.sum.keys.x[d][a] - f.sum.keys.x[d][b];
        if (d == 1 && f.sum.space == SumSpace::wrapped) away -= std::nearbyint(away);
        square += away * away;
    }
    return std::sqrt(square);
}

std::array<std::size_t, 2> closest_keys(const FieldImpl& f) {
    std::array<std::size_t, 2> pair{0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < f.keys.size(); ++a)
        for (std::size_t b = a + 1; b < f.keys.size(); ++b)
            if (const double d = feature_distance(f, a, b); d < least) least = d, pair = {a, b};
    return pair;
}

Eigen::MatrixXd key_matrix(const FieldImpl& f, const Kernel& kernel, double ridge) {
    const std::size_t M = f.keys.size();
    Eigen::MatrixXd A(M, M);
    for (std::size_t k = 0; k < M; ++k)
        kernel_column(kernel, f.sum.space, f.sum.keys, {f.sum.keys.x[0][k], f.sum.keys.x[1][k], f.sum.keys.x[2][k]},
                      A.col(static_cast<Eigen::Index>(k)).data());
    if (ridge > 0.0) A.diagonal().array() += ridge * kernel.phi(0.0);
    return A;
}

Eigen::MatrixXd tail_matrix(const FieldImpl& f) {
    const int m = f.tail_columns();
    Eigen::MatrixXd P(f.keys.size(), m);
    if (m == 0) return P;
    std::vector<double> u, v;
    for (const FieldKey& key : f.keys) u.push_back(key.uv.x()), v.push_back(key.uv.y());
    SurfaceBatch surface;
    if (f.options.tail == FieldTail::spatial) f.surface.evaluate(u, v, 0, surface);
    for (std::size_t k = 0; k < f.keys.size(); ++k) {
        double row[4], unused_u[4], unused_v[4];
        f.tail_row(u[k], v[k], &surface, k, row, unused_u, unused_v);
        for (int c = 0; c < m; ++c) P(static_cast<Eigen::Index>(k), c) = row[c];
    }
    return P;
}

Result<Eigen::MatrixXd> interpolated_values(FieldImpl& f) {
    const auto M = static_cast<Eigen::Index>(f.keys.size());
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(M, 3);
    if (f.options.mode == FieldMode::logmap) {
        if (f.options.base) {
            f.base = f.options.base->normalized();
        } else {
            // Spherical mean: B <- exp_B(mean log_B T_k).
            Vec3 sum = Vec3::Zero();
            for (const FieldKey& key : f.keys) sum += key.axis;
            f.base = sum.norm() > 1e-9 ? sum.normalized() : f.keys.front().axis;
            for (int step = 0; step < 200; ++step) {
                Vec3 mean = Vec3::Zero();
                for (const FieldKey& key : f.keys) mean += sphere_log(f.base, key.axis) / static_cast<double>(M);
                f.base = sphere_exp(f.base, mean);
                if (mean.norm() < 1e-15) break;
            }
        }
        f.base_frame.col(2) = f.base;
        f.base_frame.col(0) = any_perpendicular(f.base);
        f.base_frame.col(1) = f.base.cross(f.base_frame.col(0));
    }
    for (Eigen::Index k = 0; k < M; ++k) {
        const FieldKey& key = f.keys[static_cast<std::size_t>(k)];
        if (f.options.mode == FieldMode::logmap) {
            const double angle = angle_between(f.base, key.axis);
            if (angle > radians(150.0))
                return bad(
                    fmt::format("key {}: axis is {:.3f} deg from the base axis of mode logmap, limit 150 deg; use mode karcher "
                                "or lean",
                                k, degrees(angle)));
            const Vec3 l = sphere_log(f.base, key.axis);
            T.row(k) = Vec3(l.dot(f.base_frame.col(0)), l.dot(f.base_frame.col(1)), 0.0).transpose();
        } else if (f.options.mode == FieldMode::lean) {
            const SurfacePoint p = f.surface.at(key.uv.x(), key.uv.y());
            const Vec3 N = f.surface.normal_sign() * p.Su.cross(p.Sv);
            if (!(N.norm() > 1e-10 * p.Su.norm() * p.Sv.norm()) || N.norm() == 0.0)
                return bad(
                    fmt::format("key {}: the surface has no frame there (a pole or a collapsed edge): mode lean cannot be used; "
                                "use logmap",
                                k));
            const Vec3 n = N.normalized(), e1 = p.Su.normalized(), e2 = n.cross(e1);
            const Vec3 l = sphere_log(n, key.axis);
            if (l.norm() > 0.8 * f.options.lean_cap)
                return bad(
                    fmt::format("key {}: axis leans {:.3f} deg from the normal, mode lean allows 0.8 of its cap, {:.3f} deg", k,
                                degrees(l.norm()), degrees(0.8 * f.options.lean_cap)));
            T.row(k) = Vec3(l.dot(e1), l.dot(e2), 0.0).transpose();
        } else {
            T.row(k) = key.axis.transpose();
        }
    }
    return T;
}

}  // namespace detail

Result<OrientationField> OrientationField::build(const FieldSurface& surface, std::vector<FieldKey> keys,
                                                 const FieldOptions& options, const Control& control) {
    auto impl = std::make_shared<Impl>(surface);
    FieldImpl& f = *impl;
    f.options = options;
    f.keys = std::move(keys);
    if (auto ok = check_keys_alone(f); !ok) return fail_up(std::move(ok));
    for (FieldKey& key : f.keys) {
        key.axis.normalize();
        key.uv.x() = std::clamp(key.uv.x(), 0.0, 1.0);
        key.uv.y() = options.half_open ? f.wrap(key.uv.y()) : std::clamp(key.uv.y(), 0.0, 1.0);
    }
    f.given = f.keys;
    const bool many = options.solver == FieldSolver::partition ||
                      (options.solver == FieldSolver::automatic && f.keys.size() > kMostDense && options.mode == FieldMode::raw);
    if (!many && f.keys.size() > kMostDense)
        return bad(fmt::format(
            "{} keys are too many for a dense solve (limit {}); use solver = \"partition\" with mode = \"raw\", or thin "
            "the keys",
            f.keys.size(), kMostDense));
    if (many && options.mode != FieldMode::raw) return bad("a partition of unity needs mode = \"raw\"");
    // A partition works in parameters: that is its distance.
    if (many) f.options.distance = options.half_open ? FieldDistance::cylinder : FieldDistance::param;
    if (!options.half_open &&
        (f.options.distance == FieldDistance::cylinder || f.options.distance == FieldDistance::embedded_cylinder))
        return bad(fmt::format("distance = \"{}\" needs kind = \"half-open\"", name_of(f.options.distance)));
    if (f.options.kernel.shape() != 0.0 && !options.auto_shape)
        if (auto ok = check_kernel(f.options.kernel, f.options.distance == FieldDistance::cylinder && !many); !ok)
            return fail_up(std::move(ok));
    if (f.options.kernel.kind == KernelKind::cosine && (f.options.kernel.N < 2 || f.options.kernel.N > 6))
        return bad("cosine kernel needs N from 2 to 6");
    if (options.grid[0] < 3 || options.grid[1] < 3) return bad("grid needs at least 3 points each way");
    if (!(options.ridge >= 0.0)) return bad(fmt::format("ridge = {:g} must not be negative", options.ridge));
    resolve_distance(f);
    place_keys(f);
    std::vector<std::size_t> names;
    if (auto ok = merge_keys(f, names); !ok) return fail_up(std::move(ok));
    if (auto ok = check_axes(f, names); !ok) return fail_up(std::move(ok));
    check_edges(f);
    if (control.cancelled()) return fail_cancelled("orientation field");
    if (options.half_open && !surface.closed_v())
        f.report.warnings.push_back(
            "toff: the field is half-open but the surface does not close in v: it joins v = 0 and v = 1 all the same");

    if (many) {
        auto partition = detail::make_partition(f.keys, f.options, control);
        if (!partition) return fail_up(std::move(partition));
        f.partition = std::move(*partition);
        f.report.rcond = f.partition->rcond;
        f.report.residual = f.partition->residual;
        f.options.kernel = f.partition->sum.kernel;
        f.options.tail = FieldTail::constant;
        constexpr double kMostResidual = 1e-9;
        if (!(f.report.residual <= kMostResidual) || f.report.rcond == 0.0)
            return bad(fmt::format(
                "a cell of the partition was not solved (rcond {:.2e}, residual {:.2e}): keys lie too close together; "
                "thin them",
                f.report.rcond, f.report.residual));
    } else {
        f.report.fill_distance = fill_distance(f);
        auto values = detail::interpolated_values(f);
        if (!values) return fail_up(std::move(values));
        if (auto ok = resolve_kernel(f, *values); !ok) return fail_up(std::move(ok));
        if (auto ok = solve(f, *values, names); !ok) return fail_up(std::move(ok));
    }
    f.report.keys = f.keys.size();
    f.report.partition = many;
    f.report.kernel = f.options.kernel;
    f.report.distance = f.options.distance;
    f.report.tail = f.options.tail;
    f.report.scale = f.options.scale;
    f.report.q = f.options.q;
    f.report.ridge = f.options.ridge;
    if (auto ok = add_spline(f, control); !ok) return fail_up(std::move(ok));
    if (auto ok = detail::measure(f, control); !ok) return fail_up(std::move(ok));
    return OrientationField(std::move(impl));
}

std::vector<Vec3> OrientationField::leave_one_out() const {
    const Impl& f = *impl_;
    TRUNNION_REQUIRE(!f.partition);
    auto system =
        detail::KeySystem::factor(detail::key_matrix(f, f.options.kernel, f.options.ridge), detail::tail_matrix(f), definite(f));
    TRUNNION_REQUIRE(system.has_value());
    const Eigen::VectorXd d = system->inverse_diagonal();
    std::vector<Vec3> errors(f.keys.size());
    for (std::size_t k = 0; k < errors.size(); ++k)
        errors[k] = Vec3(f.sum.c[0][k], f.sum.c[1][k], f.sum.c[2][k]) / d[static_cast<Eigen::Index>(k)];
    return errors;
}

}  // namespace trunnion
