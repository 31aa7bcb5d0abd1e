// What a field is worth: lengths of the raw vector, angles at the keys, indices of smoothness.
#include <fmt/format.h>

#include "orientation/field_impl.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

FieldIndices grid_indices(const std::vector<Vec3>& T, int count_u, int count_v) {
    TRUNNION_REQUIRE(count_u >= 3 && count_v >= 3 &&
                     T.size() == static_cast<std::size_t>(count_u) * static_cast<std::size_t>(count_v));
    const auto at = [&](int i, int j) -> const Vec3& {
        return T[static_cast<std::size_t>(i) * static_cast<std::size_t>(count_v) + static_cast<std::size_t>(j)];
    };
    const double per_u = count_u - 1.0, per_v = count_v - 1.0;
    FieldIndices sum;
    for (int i = 1; i + 1 < count_u; ++i)
        for (int j = 1; j + 1 < count_v; ++j) {
            const Vec3 a = (at(i + 1, j) - at(i - 1, j)) * per_u, b = (at(i, j + 1) - at(i, j - 1)) * per_v;
            sum.S_TD += 0.125 * (a + b).squaredNorm();
            sum.S_D += 0.125 * (a.squaredNorm() + b.squaredNorm());
        }
    const double points = (count_u - 2.0) * (count_v - 2.0);
    return {sum.S_TD / points, sum.S_D / points};
}

namespace detail {

namespace {

constexpr double kVanished = 0.05, kShort = 0.5;

Result<FieldBatch> on_grid(const FieldImpl& f, bool with_spline, const Control& control) {
    const auto [nu, nv] = f.options.grid;
    std::vector<double> u, v;
    u.reserve(static_cast<std::size_t>(nu) * static_cast<std::size_t>(nv));
    v.reserve(u.capacity());
    for (int i = 0; i < nu; ++i)
        for (int j = 0; j < nv; ++j) u.push_back(i / (nu - 1.0)), v.push_back(j / (nv - 1.0));
    FieldBatch batch;
    if (auto done = f.evaluate(u, v, 0, with_spline, batch, control); !done) return fail_up(std::move(done));
    return batch;
}

/// |R(x)| >= |R(x0)| - L d(x, x0), L = max|phi'| sum |c_k| + the tail's slope: true where this shows |R| > 0.05 over every cell
/// of a subdivision of the square. Gives up (false) at cells of 1e-3, or where the work would be out of proportion.
Result<bool> certify(const FieldImpl& f, const Control& control) {
    const FieldOptions& o = f.options;
    if (o.mode != FieldMode::raw) return true;  // unit by construction
    if (f.partition || o.tail == FieldTail::spatial) return false;
    double sum = 0.0;
    for (std::size_t k = 0; k < f.keys.size(); ++k) sum += Vec3(f.sum.c[0][k], f.sum.c[1][k], f.sum.c[2][k]).norm();
    const double L = f.sum.kernel.steepest() * sum;
    const double tail_u = o.tail == FieldTail::linear ? f.tail.row(1).norm() : 0.0;
    const double tail_v = o.tail == FieldTail::linear && !o.half_open ? f.tail.row(2).norm() : 0.0;
    struct Cell {
        double u, v, du, dv;  // centre, half sides
    };
    const auto slack = [&](const Cell& c) -> double {
        double d = 0.0;
        if (o.distance == FieldDistance::chord) {
            const auto bound = f.surface.slope_bound({c.u - c.du, c.u + c.du}, {c.v - c.dv, c.v + c.dv});
            if (!bound) return std::numeric_limits<double>::infinity();
            d = o.scale * (bound->u * c.du + bound->v * c.dv);
        } else if (o.distance == FieldDistance::param) {
            d = std::hypot(o.su * c.du, o.sv * c.dv);
        } else {
            d = std::hypot(o.q * c.du, c.dv);  // on the embedded cylinder the chord is shorter still
        }
        return L * d + tail_u * c.du + tail_v * c.dv;
    };
    constexpr double kLeastCell = 1e-3;
    constexpr std::size_t kMostCells = 50'000;
    if (slack({0.5, 0.5, 0.5 * kLeastCell, 0.5 * kLeastCell}) > 1.0) return false;  // hopeless: do not start
    std::vector<Cell> cells;
    constexpr int kStart = 16;
    for (int i = 0; i < kStart; ++i)
        for (int j = 0; j < kStart; ++j) cells.push_back({(i + 0.5) / kStart, (j + 0.5) / kStart, 0.5 / kStart, 0.5 / kStart});
    while (!cells.empty()) {
        std::vector<double> u, v;
        for (const Cell& c : cells) u.push_back(c.u), v.push_back(c.v);
        FieldBatch batch;
        if (auto done = f.evaluate(u, v, 0, false, batch, control); !done) return fail_up(std::move(done));
        std::vector<Cell> next;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const Cell& c = cells[i];
            if (batch.raw[i].norm() - slack(c) > kVanished) continue;
            if (2.0 * c.du < kLeastCell || next.size() > kMostCells) return false;
            for (const double a : {-0.5, 0.5})
                for (const double b : {-0.5, 0.5}) next.push_back({c.u + a * c.du, c.v + b * c.dv, 0.5 * c.du, 0.5 * c.dv});
        }
        cells = std::move(next);
    }
    return true;
}

/// 1/2 integral (G |t_u|^2 - 2 F t_u.t_v + E |t_v|^2) / sqrt(EG - F^2) du dv: three-point Gauss rules on 20 x 20 panels. Infinite
/// where the surface has no area element.
Result<double> dirichlet(const FieldImpl& f, const Control& control) {
    constexpr int kPanels = 20;
    constexpr std::array<double, 3> kAt{0.1127016653792583, 0.5, 0.8872983346207417}, kWeight{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    std::vector<double> u, v, w;
    for (int i = 0; i < kPanels; ++i)
        for (int j = 0; j < kPanels; ++j)
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b) {
                    u.push_back((i + kAt[a]) / kPanels);
                    v.push_back((j + kAt[b]) / kPanels);
                    w.push_back(kWeight[a] * kWeight[b] / (kPanels * kPanels));
                }
    SurfaceBatch s;
    f.surface.evaluate(u, v, 1, s);
    FieldBatch batch;
    if (auto done = f.evaluate(u, v, 1, true, batch, control); !done) return fail_up(std::move(done));
    double sum = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        const Vec3 Su(s.plane(3)[i], s.plane(4)[i], s.plane(5)[i]), Sv(s.plane(6)[i], s.plane(7)[i], s.plane(8)[i]);
        const double E = Su.squaredNorm(), F = Su.dot(Sv), G = Sv.squaredNorm(), area = Su.cross(Sv).norm();
        const Vec3 &a = batch.unit_u[i], &b = batch.unit_v[i];
        sum += 0.5 * w[i] * (G * a.squaredNorm() - 2.0 * F * a.dot(b) + E * b.squaredNorm()) / area;
    }
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

}  // namespace

Result<void> measure(FieldImpl& f, const Control& control) {
    FieldReport& r = f.report;
    const auto [nu, nv] = f.options.grid;
    auto rbf = on_grid(f, false, control);
    if (!rbf) return fail_up(std::move(rbf));
    r.least_raw = std::numeric_limits<double>::infinity();
    r.greatest_raw = 0.0;
    for (std::size_t i = 0; i < rbf->raw.size(); ++i) {
        const double length = rbf->raw[i].norm();
        r.greatest_raw = std::max(r.greatest_raw, length);
        if (!(length < r.least_raw)) continue;
        r.least_raw = length;
        r.least_raw_uv = {static_cast<double>(i / static_cast<std::size_t>(nv)) / (nu - 1.0),
                          static_cast<double>(i % static_cast<std::size_t>(nv)) / (nv - 1.0)};
    }
    const Vec2 native = f.surface.to_native(r.least_raw_uv);
    const std::string place =
        fmt::format("toff: field vanishes near u {:.6f} v {:.6f} (length {:.3g})", native.x(), native.y(), r.least_raw);
    if (!(r.least_raw >= kVanished)) return fail(ErrorCode::no_solution, place);
    if (r.least_raw < kShort) r.warnings.push_back(place);
    auto certified = certify(f, control);
    if (!certified) return fail_up(std::move(certified));
    r.certified = *certified;

    r.rbf_unit = grid_indices(rbf->unit, nu, nv);
    r.rbf_raw = grid_indices(rbf->raw, nu, nv);
    r.unit = r.rbf_unit;
    r.raw = r.rbf_raw;
    if (f.spline) {
        auto splined = on_grid(f, true, control);
        if (!splined) return fail_up(std::move(splined));
        r.unit = grid_indices(splined->unit, nu, nv);
        r.raw = grid_indices(splined->raw, nu, nv);
    }

    std::vector<double> u, v;
    for (const FieldKey& key : f.keys) u.push_back(key.uv.x()), v.push_back(key.uv.y());
    FieldBatch at;
    if (auto done = f.evaluate(u, v, 0, false, at, control); !done) return done;
    // With no ridge the keys are met: rounding of the solution is all that may be left.
    constexpr double kMissed = 1e-6;
    if (!(f.options.ridge > 0.0))
        for (std::size_t k = 0; k < f.keys.size(); ++k)
            if (const double angle = angle_between(f.keys[k].axis, at.unit[k]); !(degrees(angle) <= kMissed))
                return fail(
                    ErrorCode::no_solution,
                    fmt::format("toff: key {} is missed by {:.3g} deg; spread the keys or narrow the kernel", k, degrees(angle)));
    // Means are over the keys as given: a key that was merged into another counts too.
    u.clear(), v.clear();
    for (const FieldKey& key : f.given) u.push_back(key.uv.x()), v.push_back(key.uv.y());
    if (auto done = f.evaluate(u, v, 0, true, at, control); !done) return done;
    r.I_fa = r.I_fa_raw = r.largest_angle = r.mean_angle = 0.0;
    const auto M = static_cast<double>(f.given.size());
    for (std::size_t k = 0; k < f.given.size(); ++k) {
        const Vec3& T = f.given[k].axis;
        const double angle = angle_between(T, at.unit[k]);
        r.I_fa += T.dot(at.unit[k]) / M;
        r.I_fa_raw += T.dot(at.raw[k]) / M;
        r.largest_angle = std::max(r.largest_angle, angle);
        r.mean_angle += angle / M;
    }
    auto energy = dirichlet(f, control);
    if (!energy) return fail_up(std::move(energy));
    r.E_D = *energy;
    return {};
}

}  // namespace detail
}  // namespace trunnion
