// Evaluation of orientation fields and their derivatives.
#include <fmt/format.h>

#include "orientation/field_impl.hpp"
#include "orientation/sphere.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

using detail::FeaturePoints;
using detail::SumSpace;

bool OrientationField::Impl::needs_surface() const {
    return options.distance == FieldDistance::chord || options.tail == FieldTail::spatial || options.mode == FieldMode::lean;
}

SumSpace OrientationField::Impl::space() const {
    switch (options.distance) {
        case FieldDistance::chord:
        case FieldDistance::embedded_cylinder:
            return SumSpace::space;
        case FieldDistance::cylinder:
            return SumSpace::wrapped;
        default:
            return SumSpace::flat;
    }
}

void OrientationField::Impl::features(std::span<const double> u, std::span<const double> v, int order, FeaturePoints& out) const {
    const std::size_t n = u.size();
    out.x.resize(n);
    if (order > 0)
        for (std::size_t d = 0; d < 3; ++d) {
            out.x_u[d].assign(n, 0.0);
            out.x_v[d].assign(n, 0.0);
        }
    if (needs_surface()) {
        const bool frame = options.mode == FieldMode::lean;
        surface.evaluate(u, v, frame ? order + 1 : order, out.surface);
    }
    const auto linear = [&](std::size_t d, std::span<const double> parameter, double by, bool along_u) {
        for (std::size_t i = 0; i < n; ++i) out.x.x[d][i] = by * parameter[i];
        if (order > 0) (along_u ? out.x_u : out.x_v)[d].assign(n, by);
    };
    switch (options.distance) {
        case FieldDistance::chord:
            for (std::size_t d = 0; d < 3; ++d) {
                const int k = static_cast<int>(d);
                for (std::size_t i = 0; i < n; ++i) {
                    // From the tail's centre (the keys' middle): differences then lose nothing to a far origin.
                    out.x.x[d][i] = options.scale * (out.surface.plane(k)[i] - tail_centre[k]);
                    if (order == 0) continue;
                    out.x_u[d][i] = options.scale * out.surface.plane(3 + k)[i];
                    out.x_v[d][i] = options.scale * out.surface.plane(6 + k)[i];
                }
            }
            break;
        case FieldDistance::cylinder:
            linear(0, u, options.q, true);
            linear(1, v, 1.0, false);
            break;
        case FieldDistance::embedded_cylinder: {
            constexpr double kTurn = 2.0 * kPi;
            for (std::size_t i = 0; i < n; ++i) {
                const double c = std::cos(kTurn * v[i]), s = std::sin(kTurn * v[i]);
                out.x.x[0][i] = c / kTurn;
                out.x.x[1][i] = s / kTurn;
                if (order == 0) continue;
                out.x_v[0][i] = -s;
                out.x_v[1][i] = c;
            }
            linear(2, u, options.q, true);
            break;
        }
        default:
            linear(0, u, options.su, true);
            linear(1, v, options.sv, false);
    }
}

int OrientationField::Impl::tail_columns() const {
    switch (options.tail) {
        case FieldTail::constant:
            return 1;
        case FieldTail::linear:
            return options.half_open ? 2 : 3;
        case FieldTail::spatial:
            return 4;
        default:
            return 0;
    }
}

void OrientationField::Impl::tail_row(double u, double v, const SurfaceBatch* s, std::size_t i, double* row, double* row_u,
                                      double* row_v) const {
    const int columns = tail_columns();
    if (columns == 0) return;
    std::fill(row_u, row_u + columns, 0.0);
    std::fill(row_v, row_v + columns, 0.0);
    row[0] = 1.0;
    if (options.tail == FieldTail::linear) {
        row[1] = u;
        row_u[1] = 1.0;
        if (columns == 3) row[2] = v, row_v[2] = 1.0;
    } else if (options.tail == FieldTail::spatial) {
        for (int d = 0; d < 3; ++d) {
            row[1 + d] = tail_scale * (s->plane(d)[i] - tail_centre[d]);
            if (s->order() == 0) continue;
            row_u[1 + d] = tail_scale * s->plane(3 + d)[i];
            row_v[1 + d] = tail_scale * s->plane(6 + d)[i];
        }
    }
}

namespace {

/// The surface frame (e1 along S_u, e2 = n x e1, n) as columns, with derivatives where the batch has second ones.
struct LeanFrame {
    Vec3 e1, e2, n, e1_u, e2_u, n_u, e1_v, e2_v, n_v;
};

std::optional<LeanFrame> lean_frame(const SurfaceBatch& s, std::size_t i, double sign) {
    const auto vector = [&](int first) { return Vec3(s.plane(first)[i], s.plane(first + 1)[i], s.plane(first + 2)[i]); };
    const Vec3 Su = vector(3), Sv = vector(6), N = sign * Su.cross(Sv);
    constexpr double kRegular = 1e-10;  // below, the frame is rounding: a pole or a collapsed edge
    if (!(N.norm() > kRegular * Su.norm() * Sv.norm()) || !(Su.norm() > 0.0) || !(Sv.norm() > 0.0)) return {};
    LeanFrame f{};
    f.e1 = Su.normalized();
    f.n = N.normalized();
    f.e2 = f.n.cross(f.e1);
    if (s.order() < 2) return f;
    const Vec3 Suu = vector(9), Suv = vector(12), Svv = vector(15);
    const auto turn = [](const Vec3& unit, double length, const Vec3& change) -> Vec3 {
        return (change - change.dot(unit) * unit) / length;
    };
    f.e1_u = turn(f.e1, Su.norm(), Suu);
    f.e1_v = turn(f.e1, Su.norm(), Suv);
    f.n_u = turn(f.n, N.norm(), sign * (Suu.cross(Sv) + Su.cross(Suv)));
    f.n_v = turn(f.n, N.norm(), sign * (Suv.cross(Sv) + Su.cross(Svv)));
    f.e2_u = f.n_u.cross(f.e1) + f.n.cross(f.e1_u);
    f.e2_v = f.n_v.cross(f.e1) + f.n.cross(f.e1_v);
    return f;
}

/// exp of (x, y) in the frame (e1, e2, n), and its change when coordinates and frame change.
struct TangentPoint {
    double x, y, angle, sine_ratio;
};
Vec3 exp_in(const TangentPoint& p, const Vec3& e1, const Vec3& e2, const Vec3& n) {
    return (std::cos(p.angle) * n + p.sine_ratio * (p.x * e1 + p.y * e2)).normalized();
}
Vec3 exp_change(const TangentPoint& p, double dx, double dy, const Vec3& e1, const Vec3& e2, const Vec3& n) {
    const double along = p.x * dx + p.y * dy;  // angle times its change
    return -p.sine_ratio * along * n + p.sine_ratio * (dx * e1 + dy * e2) +
           detail::sinc_slope(p.angle) * along * (p.x * e1 + p.y * e2);
}

/// Leans above 0.8 of the cap are bent back below it, smoothly: x -> 0.8 cap + 0.2 cap tanh((x - 0.8 cap) / (0.2 cap)).
void cap_lean(double cap, double& x, double& y, double* dx, double* dy) {
    const double lean = std::hypot(x, y), soft = 0.8 * cap, room = 0.2 * cap;
    if (!(lean > soft)) return;
    const double t = std::tanh((lean - soft) / room), capped = soft + room * t;
    const double ratio = capped / lean, ratio_slope = ((1.0 - t * t) - ratio) / lean;  // d ratio / d lean
    for (int k = 0; k < 2; ++k) {
        const double change = ratio_slope * (x * dx[k] + y * dy[k]) / lean;
        dx[k] = ratio * dx[k] + change * x;
        dy[k] = ratio * dy[k] + change * y;
    }
    x *= ratio;
    y *= ratio;
}

}  // namespace

Result<void> OrientationField::Impl::evaluate_chunk(std::span<const double> u, std::span<const double> v, int order,
                                                    std::size_t first, FieldBatch& out) const {
    const std::size_t n = u.size();
    const bool slopes = order > 0;
    if (partition) {
        for (std::size_t i = 0; i < n; ++i) {
            Vec3 R, Ru, Rv;
            partition->evaluate(u[i], v[i], slopes, R, Ru, Rv);
            out.raw[first + i] = R;
            if (slopes) out.raw_u[first + i] = Ru, out.raw_v[first + i] = Rv;
        }
    } else {
        thread_local FeaturePoints f;
        features(u, v, order, f);
        if (options.mode == FieldMode::karcher) return evaluate_karcher(f, u, v, order, first, out);
        thread_local std::array<std::vector<double>, 12> planes;
        std::array<double*, 3> value{};
        std::array<double*, 9> gradient{};
        for (std::size_t k = 0; k < 12; ++k) {
            planes[k].resize(n);
            (k < 3 ? value[k] : gradient[k - 3]) = planes[k].data();
        }
        sum.evaluate(f.x, 0, n, value, slopes ? &gradient : nullptr);
        const int columns = tail_columns();
        for (std::size_t i = 0; i < n; ++i) {
            Vec3 R(value[0][i], value[1][i], value[2][i]), Ru = Vec3::Zero(), Rv = Vec3::Zero();
            if (slopes)
                for (std::size_t d = 0; d < 3; ++d) {
                    const Vec3 g(gradient[3 * d][i], gradient[3 * d + 1][i], gradient[3 * d + 2][i]);
                    Ru += f.x_u[d][i] * g;
                    Rv += f.x_v[d][i] * g;
                }
            if (columns > 0) {
                double row[4], row_u[4], row_v[4];
                tail_row(u[i], v[i], &f.surface, i, row, row_u, row_v);
                for (int k = 0; k < columns; ++k) {
                    const Vec3 b = tail.row(k).transpose();
                    R += row[k] * b;
                    Ru += row_u[k] * b;
                    Rv += row_v[k] * b;
                }
            }
            if (options.mode == FieldMode::logmap || options.mode == FieldMode::lean) {
                double x = R.x(), y = R.y(), dx[2] = {Ru.x(), Rv.x()}, dy[2] = {Ru.y(), Rv.y()};
                LeanFrame frame{};
                if (options.mode == FieldMode::logmap) {
                    frame.e1 = base_frame.col(0);
                    frame.e2 = base_frame.col(1);
                    frame.n = base;
                } else {
                    const auto there = lean_frame(f.surface, i, surface.normal_sign());
                    if (!there) {
                        const Vec2 native = surface.to_native({u[i], v[i]});
                        return fail(
                            ErrorCode::no_solution,
                            fmt::format("toff: no surface frame at u {:.6f} v {:.6f} (a pole or a collapsed edge): mode lean "
                                        "cannot be used there; use logmap",
                                        native.x(), native.y()));
                    }
                    frame = *there;
                    cap_lean(options.lean_cap, x, y, dx, dy);
                }
                const double angle = std::hypot(x, y);
                const TangentPoint p{x, y, angle, detail::sinc(angle)};
                R = exp_in(p, frame.e1, frame.e2, frame.n);
                if (slopes) {
                    Ru = exp_change(p, dx[0], dy[0], frame.e1, frame.e2, frame.n);
                    Rv = exp_change(p, dx[1], dy[1], frame.e1, frame.e2, frame.n);
                    if (options.mode == FieldMode::lean) {
                        const double c = std::cos(angle), s = p.sine_ratio;
                        Ru += c * frame.n_u + s * (x * frame.e1_u + y * frame.e2_u);
                        Rv += c * frame.n_v + s * (x * frame.e1_v + y * frame.e2_v);
                    }
                }
            }
            out.raw[first + i] = R;
            if (slopes) out.raw_u[first + i] = Ru, out.raw_v[first + i] = Rv;
        }
    }
    return {};
}

Result<void> OrientationField::Impl::evaluate_karcher(const FeaturePoints& f, std::span<const double> u,
                                                      std::span<const double> v, int order, std::size_t first,
                                                      FieldBatch& out) const {
    // Weights are the cardinal functions of the system: K w = [phi(x); p(x)], K symmetric. The mean solves sum w_k log_t T_k = 0.
    const Eigen::Index M = system->keys(), m = system->tail();
    const auto n = static_cast<Eigen::Index>(u.size());
    const int parts = order > 0 ? 3 : 1;
    Eigen::MatrixXd rhs(M + m, n * parts);
    std::vector<double> phi(static_cast<std::size_t>(M)), h(static_cast<std::size_t>(M));
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const std::array<double, 3> x{f.x.x[0][k], f.x.x[1][k], f.x.x[2][k]};
        detail::kernel_column(sum.kernel, sum.space, sum.keys, x, phi.data(), h.data());
        double row[4], row_u[4], row_v[4];
        tail_row(u[k], v[k], &f.surface, k, row, row_u, row_v);
        for (Eigen::Index j = 0; j < M; ++j) {
            const auto key = static_cast<std::size_t>(j);
            rhs(j, i) = phi[key];
            if (order == 0) continue;
            double along_u = 0.0, along_v = 0.0;
            for (std::size_t d = 0; d < 3; ++d) {
                double away = x[d] - sum.keys.x[d][key];
                if (d == 1 && sum.space == SumSpace::wrapped) away -= std::nearbyint(away);
                along_u += away * f.x_u[d][k];
                along_v += away * f.x_v[d][k];
            }
            rhs(j, n + i) = h[key] * along_u;
            rhs(j, 2 * n + i) = h[key] * along_v;
        }
        for (Eigen::Index c = 0; c < m; ++c) {
            rhs(M + c, i) = row[c];
            if (order > 0) rhs(M + c, n + i) = row_u[c], rhs(M + c, 2 * n + i) = row_v[c];
        }
    }
    const Eigen::MatrixXd W = system->solve(rhs).topRows(M);
    constexpr int kMostSteps = 60;
    for (Eigen::Index i = 0; i < n; ++i) {
        Vec3 t = Vec3::Zero();
        for (Eigen::Index j = 0; j < M; ++j) t += W(j, i) * keys[static_cast<std::size_t>(j)].axis;
        const auto lost = [&](std::string_view what) {
            const Vec2 native = surface.to_native({u[static_cast<std::size_t>(i)], v[static_cast<std::size_t>(i)]});
            return fail(
                ErrorCode::no_solution,
                fmt::format("toff: the spherical mean of the keys {} at u {:.6f} v {:.6f}: use mode logmap or lean, or add keys",
                            what, native.x(), native.y()));
        };
        if (!(t.norm() > 1e-3)) return lost("has no direction");  // the weights cancel: any start would be as good
        t.normalize();
        // Rounding of the sum itself: it cannot get closer than a few ulp of its terms.
        const double settled = std::max(1e-14, 4.0 * std::numeric_limits<double>::epsilon() * W.col(i).lpNorm<1>());
        int step = 0;
        for (double moved = 1.0; moved > settled; ++step) {
            if (step == kMostSteps) return lost("does not settle");
            Vec3 s = Vec3::Zero();
            for (Eigen::Index j = 0; j < M; ++j) s += W(j, i) * detail::sphere_log(t, keys[static_cast<std::size_t>(j)].axis);
            moved = s.norm();
            if (!(moved < kPi)) return lost("does not settle");
            t = detail::sphere_exp(t, s);
        }
        const auto at = first + static_cast<std::size_t>(i);
        out.raw[at] = t;
        if (order == 0) continue;
        // d(log_t T)[a] = -(<a, e> e + x cot x (a - <a, e> e)) for a tangent a, e the unit direction to T, x the angle: the mean
        // moves by the solution of H a = sum dw_k log_t T_k. H is symmetric on the tangent plane; n n^T makes it regular.
        Mat3 H = t * t.transpose();
        Vec3 gu = Vec3::Zero(), gv = Vec3::Zero();
        for (Eigen::Index j = 0; j < M; ++j) {
            const Vec3 l = detail::sphere_log(t, keys[static_cast<std::size_t>(j)].axis);
            const double x = l.norm();
            const Vec3 e = x > 0.0 ? Vec3(l / x) : Vec3(Vec3::Zero());
            const double ratio = x > 1e-4 ? x / std::tan(x) : 1.0 - x * x / 3.0;
            H += W(j, i) * ((1.0 - ratio) * e * e.transpose() + ratio * (Mat3::Identity() - t * t.transpose()));
            gu += W(j, n + i) * l;
            gv += W(j, 2 * n + i) * l;
        }
        const Eigen::PartialPivLU<Mat3> lu(H);
        out.raw_u[at] = lu.solve(gu);
        out.raw_v[at] = lu.solve(gv);
    }
    return {};
}

Result<void> OrientationField::Impl::evaluate(std::span<const double> u, std::span<const double> v, int order, bool with_spline,
                                              FieldBatch& out, const Control& control) const {
    TRUNNION_REQUIRE(u.size() == v.size() && (order == 0 || order == 1));
    const std::size_t n = u.size();
    for (auto* values : {&out.unit, &out.raw}) values->resize(n);
    for (auto* values : {&out.unit_u, &out.unit_v, &out.raw_u, &out.raw_v}) values->resize(order > 0 ? n : 0);
    const bool splined = with_spline && spline;
    // A block's points, planes and frames stay in the caches; the weights of a spherical mean need a column of M numbers per
    // point.
    const std::size_t grain = options.mode == FieldMode::karcher && !splined ? 64 : 512;
    std::vector<std::optional<Error>> errors((n + grain - 1) / grain);
    auto done = parallel_for(n, grain, control, "orientation field", [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<double> uu, vv;
        uu.assign(u.begin() + static_cast<std::ptrdiff_t>(begin), u.begin() + static_cast<std::ptrdiff_t>(end));
        vv.assign(v.begin() + static_cast<std::ptrdiff_t>(begin), v.begin() + static_cast<std::ptrdiff_t>(end));
        for (double& x : vv) x = wrap(x);
        if (splined) {
            thread_local SurfaceBatch batch;
            spline->evaluate(uu, vv, order, batch);
            for (std::size_t i = begin; i < end; ++i) {
                const auto vector = [&](int k) {
                    return Vec3(batch.plane(k)[i - begin], batch.plane(k + 1)[i - begin], batch.plane(k + 2)[i - begin]);
                };
                out.raw[i] = vector(0);
                if (order > 0) out.raw_u[i] = vector(3), out.raw_v[i] = vector(6);
            }
        } else if (auto chunk = evaluate_chunk(uu, vv, order, begin, out); !chunk) {
            errors[begin / grain] = std::move(chunk.error());
            return;
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3& R = out.raw[i];
            const double length = R.norm();
            const Vec3 t = length > 0.0 ? Vec3(R / length) : Vec3(Vec3::UnitZ());
            out.unit[i] = t;
            if (order == 0) continue;
            out.unit_u[i] = (out.raw_u[i] - out.raw_u[i].dot(t) * t) / length;
            out.unit_v[i] = (out.raw_v[i] - out.raw_v[i].dot(t) * t) / length;
        }
    });
    if (!done) return done;
    for (auto& error : errors)
        if (error) return tl::unexpected(std::move(*error));
    return {};
}

Result<void> OrientationField::evaluate(std::span<const double> u, std::span<const double> v, int order, FieldBatch& out,
                                        const Control& control) const {
    return impl_->evaluate(u, v, order, true, out, control);
}

Vec3 OrientationField::axis(double u, double v) const {
    FieldBatch one;
    const auto done = evaluate({&u, 1}, {&v, 1}, 0, one);
    TRUNNION_REQUIRE(done.has_value());
    return one.unit.front();
}

const FieldReport& OrientationField::report() const {
    return impl_->report;
}
const FieldOptions& OrientationField::options() const {
    return impl_->options;
}
const std::vector<FieldKey>& OrientationField::keys() const {
    return impl_->keys;
}
const FieldSurface& OrientationField::surface() const {
    return impl_->surface;
}

}  // namespace trunnion
