// Partition of unity: fields through tens of thousands of keys.
//
// Cost per evaluation: 2.5 patches of 100 keys on average, 12 flops and a root per key: about 4000 flops. Building: one Cholesky
// of 100 x 100 per 40 keys, 8500 flops a key.
#include <algorithm>

#include <fmt/format.h>

#include "orientation/field_impl.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion::detail {

namespace {

constexpr double kKeysPerCell = 40.0, kRadius = 0.9, kWidth = 1.2;
constexpr std::size_t kLeastKeys = 8, kPad = 8;

struct CellGrid {
    double hu, hv;
    int reach_u, reach_v;
};

CellGrid grid_of(const Partition& p) {
    const double hu = p.scale_u / p.cells_u, hv = p.scale_v / p.cells_v;
    return {hu, hv, static_cast<int>(std::floor(p.radius / hu + 0.5)), static_cast<int>(std::floor(p.radius / hv + 0.5))};
}

int cell_at(double x, double h, int cells) {
    return std::clamp(static_cast<int>(std::floor(x / h)), 0, cells - 1);
}

/// Calls visit(cell, dx, dy) for the cells whose centre lies within `radius` of (x, y), a metric point.
template <class Visit>
void for_cells_near(const Partition& p, double x, double y, double radius, Visit&& visit) {
    const CellGrid g = grid_of(p);
    const int reach_u = static_cast<int>(std::floor(radius / g.hu + 0.5)),
              reach_v = static_cast<int>(std::floor(radius / g.hv + 0.5));
    const int iu = cell_at(x, g.hu, p.cells_u), iv = cell_at(y, g.hv, p.cells_v);
    for (int i = std::max(0, iu - reach_u); i <= std::min(p.cells_u - 1, iu + reach_u); ++i)
        for (int k = iv - reach_v; k <= iv + reach_v; ++k) {
            int j = k;
            if (p.wrapped)
                j = (k % p.cells_v + p.cells_v) % p.cells_v;
            else if (k < 0 || k >= p.cells_v)
                continue;
            const double dx = x - (i + 0.5) * g.hu, dy = y - (k + 0.5) * g.hv;
            if (dx * dx + dy * dy < radius * radius)
                visit(static_cast<std::size_t>(i) * static_cast<std::size_t>(p.cells_v) + static_cast<std::size_t>(j), dx, dy);
        }
}

}  // namespace

void Partition::evaluate(double u, double v, bool derivatives, Vec3& R, Vec3& Ru, Vec3& Rv) const {
    const double x = scale_u * u, y = scale_v * v;
    Vec3 total = Vec3::Zero(), total_x = Vec3::Zero(), total_y = Vec3::Zero();
    double weight = 0.0, weight_x = 0.0, weight_y = 0.0;
    for_cells_near(*this, x, y, radius, [&](std::size_t cell, double dx, double dy) {
        const double t = std::sqrt(dx * dx + dy * dy) / radius, s = 1.0 - t;
        const double w = s * s * s * s * (4.0 * t + 1.0);
        double sums[9];
        patch_sum(sum, first[cell], first[cell + 1], {x, y}, derivatives, sums);
        const Vec3 P = constant[cell] + Vec3(sums[0], sums[1], sums[2]);
        weight += w;
        total += w * P;
        if (!derivatives) return;
        const double slope = -20.0 * s * s * s / (radius * radius), wx = slope * dx, wy = slope * dy;
        weight_x += wx;
        weight_y += wy;
        total_x += wx * P + w * Vec3(sums[3], sums[4], sums[5]);
        total_y += wy * P + w * Vec3(sums[6], sums[7], sums[8]);
    });
    R = total / weight;  // every point lies within 0.71 cells of a centre, so weight > 0
    if (!derivatives) return;
    Ru = scale_u * (total_x - weight_x * R) / weight;
    Rv = scale_v * (total_y - weight_y * R) / weight;
}

Result<Partition> make_partition(const std::vector<FieldKey>& keys, const FieldOptions& options, const Control& control) {
    Partition p;
    p.wrapped = options.half_open;
    p.scale_u = options.half_open ? options.q : options.su;
    p.scale_v = options.half_open ? 1.0 : options.sv;
    const double side = std::sqrt(p.scale_u * p.scale_v * kKeysPerCell / static_cast<double>(keys.size()));
    p.cells_u = std::max(1, static_cast<int>(std::lround(p.scale_u / side)));
    p.cells_v = std::max(p.wrapped ? 4 : 1, static_cast<int>(std::lround(p.scale_v / side)));
    const CellGrid g = grid_of(p);
    const double cell = std::max(g.hu, g.hv);
    p.radius = kRadius * cell;
    const std::size_t cells = static_cast<std::size_t>(p.cells_u) * static_cast<std::size_t>(p.cells_v);

    std::vector<std::vector<std::uint32_t>> members(cells);
    for (std::size_t k = 0; k < keys.size(); ++k)
        for_cells_near(p, p.scale_u * keys[k].uv.x(), p.scale_v * keys[k].uv.y(), p.radius,
                       [&](std::size_t c, double, double) { members[c].push_back(static_cast<std::uint32_t>(k)); });
    // Where keys are scarce a patch reaches further for its keys; its weight does not.
    for (double reach = 2.0 * p.radius;; reach *= 2.0) {
        std::vector<std::uint8_t> poor(cells, 0);
        bool any = false;
        for (std::size_t c = 0; c < cells; ++c)
            if (members[c].size() < std::min(kLeastKeys, keys.size())) poor[c] = 1, any = true, members[c].clear();
        if (!any) break;
        for (std::size_t k = 0; k < keys.size(); ++k)
            for_cells_near(p, p.scale_u * keys[k].uv.x(), p.scale_v * keys[k].uv.y(), reach, [&](std::size_t c, double, double) {
                // A wrapped patch that reaches around meets a key twice.
                if (poor[c] && (members[c].empty() || members[c].back() != k))
                    members[c].push_back(static_cast<std::uint32_t>(k));
            });
    }

    p.first.assign(cells + 1, 0);
    for (std::size_t c = 0; c < cells; ++c) p.first[c + 1] = p.first[c] + (members[c].size() + kPad - 1) / kPad * kPad;
    p.sum.kernel = {KernelKind::imq, 0.0, kWidth * cell, 0.5, 2};
    p.sum.space = p.wrapped ? SumSpace::wrapped : SumSpace::flat;
    p.sum.keys.resize(p.first.back());
    for (auto& plane : p.sum.c) plane.assign(p.first.back(), 0.0);
    p.constant.assign(cells, Vec3::Zero());
    std::vector<double> rcond(cells, 1.0), residual(cells, 0.0);
    auto done = parallel_for(cells, 4, control, "orientation field", [&](std::size_t begin, std::size_t end) {
        SumPoints local;
        for (std::size_t c = begin; c < end; ++c) {
            const auto n = static_cast<Eigen::Index>(members[c].size());
            local.resize(members[c].size());
            Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n + 1, 3);
            for (Eigen::Index i = 0; i < n; ++i) {
                const FieldKey& key = keys[members[c][static_cast<std::size_t>(i)]];
                const auto k = static_cast<std::size_t>(i);
                local.x[0][k] = p.scale_u * key.uv.x();
                local.x[1][k] = p.scale_v * key.uv.y();
                T.row(i) = key.axis.transpose();
            }
            Eigen::MatrixXd A(n, n);
            for (Eigen::Index i = 0; i < n; ++i) {
                const auto k = static_cast<std::size_t>(i);
                kernel_column(p.sum.kernel, p.sum.space, local, {local.x[0][k], local.x[1][k], 0.0}, A.col(i).data());
            }
            // The patches' kernel is wide beside the spacing of keys, which makes their matrices definite but ill-conditioned:
            // LU with pivoting does not mind where Cholesky might break off.
            const Eigen::MatrixXd P = Eigen::MatrixXd::Ones(n, 1);
            auto system = KeySystem::factor(A, P, true);
            if (!system) system = KeySystem::factor(A, P, false);
            if (!system) {
                rcond[c] = 0.0;
                continue;
            }
            Eigen::MatrixXd x = system->solve(T);
            const auto defect = [&] { return Eigen::MatrixXd(T.topRows(n) - A * x.topRows(n) - P * x.bottomRows(1)); };
            Eigen::MatrixXd d = Eigen::MatrixXd::Zero(n + 1, 3);
            d.topRows(n) = defect();
            d.row(n) = -x.topRows(n).colwise().sum();
            x += system->solve(d);  // one step of refinement: the keys are met to rounding
            rcond[c] = system->rcond();
            residual[c] = defect().cwiseAbs().maxCoeff();
            const std::size_t at = p.first[c];
            for (Eigen::Index i = 0; i < n; ++i) {
                const auto k = static_cast<std::size_t>(i);
                for (std::size_t d2 = 0; d2 < 2; ++d2) p.sum.keys.x[d2][at + k] = local.x[d2][k];
                for (Eigen::Index q = 0; q < 3; ++q) p.sum.c[static_cast<std::size_t>(q)][at + k] = x(i, q);
            }
            p.constant[c] = x.row(n).transpose();
        }
    });
    if (!done) return fail_up(std::move(done));
    p.rcond = *std::min_element(rcond.begin(), rcond.end());
    p.residual = *std::max_element(residual.begin(), residual.end());
    return p;
}

}  // namespace trunnion::detail
