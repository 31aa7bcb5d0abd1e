#include "trunnion/orientation/fixed_estimate.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "orientation/fixed_quadratic.hpp"

namespace trunnion {

Result<FixedTool> FixedTool::from(const Cutter& cutter, double scallop) {
    const CutterShape shape = cutter.spec().shape;
    if ((shape != CutterShape::ball && shape != CutterShape::bull && shape != CutterShape::flat) || cutter.spec().open_bottom)
        return fail(ErrorCode::unsupported,
                    fmt::format("the fixed axis is sought for ball, bull and flat cutters with a closed bottom, not for {}{}",
                                cutter.spec().open_bottom ? "an open " : "", name_of(shape)));
    TRUNNION_REQUIRE(scallop > 0.0);
    return FixedTool{cutter.tip_major_radius(), cutter.tip_corner_radius(), scallop};
}

Result<FixedPatch> FixedPatch::of(const Face& face, bool along_u, const Grid& grid) {
    TRUNNION_REQUIRE(grid.rows > 1 && grid.columns > 1);
    if (!face.surface) return fail(ErrorCode::unsupported, "it is a mesh, which has no iso-parametric passes to count");
    const Surface& surface = *face.surface;
    const Domain& domain = surface.domain();
    const Interval running = along_u ? domain.u : domain.v, fixed = along_u ? domain.v : domain.u;
    FixedPatch patch;
    for (int row = 0; row < grid.rows; ++row) {
        const double q = fixed.at(grid.midpoints ? (row + 0.5) / grid.rows : row / (grid.rows - 1.0));
        const double dt = running.length() / (grid.columns - 1), dq = fixed.length() / grid.rows;
        double length = 0.0;
        for (int column = 0; column < grid.columns; ++column) {
            const double t = running.at(column / (grid.columns - 1.0));
            const Vec2 uv = along_u ? Vec2(t, q) : Vec2(q, t);
            if (!face.trim.whole_domain() && !face.trim.contains(uv)) continue;
            const SurfacePoint p = surface.at(uv.x(), uv.y());
            const Vec3 along = along_u ? p.Su : p.Sv, over = along_u ? p.Sv : p.Su, cross = p.Su.cross(p.Sv);
            constexpr double kFaded = 1e-9;  // a pole: the frame is lost to rounding
            if (!(cross.norm() > kFaded * p.Su.norm() * p.Sv.norm()) || cross.isZero(0.0))
                return fail(ErrorCode::no_solution,
                            fmt::format("the surface is degenerate at (u, v) = ({:.6g}, {:.6g}): cut the pole off with patch_uv",
                                        uv.x(), uv.y()));
            Sample s;
            s.n = surface.normal_sign() * cross.normalized();
            s.f = along.normalized();
            s.b = s.n.cross(s.f);
            s.form = surface_form(p, s.n, s.f);
            s.across = std::abs(over.dot(s.b)) * fixed.length();
            const double share = column == 0 || column == grid.columns - 1 ? 0.5 : 1.0;  // trapezoidal rule
            s.area = share * cross.norm() * dt * dq;
            length += share * along.norm() * dt;
            patch.samples_.push_back(s);
        }
        patch.row_end_.push_back(patch.samples_.size());
        patch.row_length_.push_back(length);
    }
    if (patch.samples_.empty())
        return fail(ErrorCode::no_solution,
                    fmt::format("the trimming leaves none of {} x {} samples: the face is too thin", grid.rows, grid.columns));
    return patch;
}

Result<FixedProblem> FixedProblem::of(const std::vector<const Face*>& faces, bool along_u, const FixedTool& tool,
                                      const FixedMargins& margins) {
    FixedProblem problem;
    problem.tool = tool;
    problem.margins = margins;
    for (const Face* face : faces) {
        // The tips of a trimmed region take whole rows or none: many thin rows.
        const int rows = face->trim.whole_domain() ? 25 : 101;
        auto patch = FixedPatch::of(*face, along_u, {rows, rows == 25 ? 25 : 51, true});
        if (!patch) return fail_in(std::move(patch), fmt::format("face {}", face->index));
        auto guard = FixedPatch::of(*face, along_u, {81, 81, false});
        if (!guard) return fail_in(std::move(guard), fmt::format("face {}", face->index));
        problem.patches.push_back(std::move(*patch));
        problem.guards.push_back(std::move(*guard));
    }
    return problem;
}

Vec3 FixedProblem::mean_normal() const {
    Vec3 sum = Vec3::Zero();
    for (const FixedPatch& patch : patches)
        for (const FixedPatch::Sample& s : patch.samples()) sum += s.area * s.n;
    const auto unit = UnitVector::from(sum);
    return unit ? unit->vec() : patches.front().samples().front().n;  // a closed body: any hemisphere is as good
}

double strip_stiffness(const FixedPatch::Sample& s, const Vec3& axis, const FixedTool& tool) {
    const FixedLean lean(s, axis, tool);
    if (!(lean.cosine > 0.0) || !lean.regular) return -1.0;
    const ScaledForm Q = scaled_form(s.form, lean, tool);
    if (!(Q.q11 > 0.0) || !(Q.det > 0.0)) return -1.0;
    return Q.det / Q.q11;
}

namespace {

/// Sum over rows of weight / narrowest strip, in ranges of the fixed parameter.
template <class Stiffness, class Weight>
double over_rows(const FixedProblem& problem, const Stiffness& stiffness, const Weight& weight) {
    double sum = 0.0;
    for (const FixedPatch& patch : problem.patches) {
        const auto rows = patch.row_end().size();
        std::size_t i = 0;
        for (std::size_t row = 0; row < rows; ++row) {
            double most = 0.0;
            for (; i < patch.row_end()[row]; ++i) {
                const FixedPatch::Sample& s = patch.samples()[i];
                const double k = stiffness(s);
                if (!(k > 0.0)) return std::numeric_limits<double>::infinity();
                most = std::max(most, k * s.across * s.across);
            }
            sum += weight(patch, row) * std::sqrt(most / (8.0 * problem.tool.scallop)) / static_cast<double>(rows);
        }
    }
    return sum;
}

double one(const FixedPatch&, std::size_t) {
    return 1.0;
}

/// Whether a sample keeps the margins.
bool keeps(const FixedPatch::Sample& s, const Vec3& axis, const FixedProblem& problem, double cos_least, double cos_greatest) {
    const double cosine = axis.dot(s.n);
    if (cosine < cos_greatest) return false;
    if (problem.tool.R_major > 0.0 && cosine > cos_least) return false;
    const FixedLean lean(s, axis, problem.tool);
    const double K = problem.margins.least_curvature;
    const ScaledForm Q = scaled_form({s.form.q11 + K, s.form.q12, s.form.q22 + K}, lean, problem.tool);
    return Q.q11 >= 0.0 && Q.det >= 0.0;  // Q - K is positive semidefinite
}

}  // namespace

double passes_needed(const FixedProblem& problem, const Vec3& axis) {
    return over_rows(
        problem, [&](const FixedPatch::Sample& s) { return strip_stiffness(s, axis, problem.tool); }, one);
}

double passes_by_section(const FixedProblem& problem, const Vec3& axis) {
    return over_rows(
        problem,
        [&](const FixedPatch::Sample& s) {
            if (!(strip_stiffness(s, axis, problem.tool) > 0.0)) return -1.0;
            const FixedLean lean(s, axis, problem.tool);
            const double r = problem.tool.r;
            // Q22 of the sheet; r = 0 has no section but at beta = 0.
            const double km = 1.0 / r, kp = lean.kp;
            return 0.5 * (km + kp) - 0.5 * (km - kp) * lean.cos2 - s.form.q22;
        },
        one);
}

double length_needed(const FixedProblem& problem, const Vec3& axis) {
    return over_rows(
        problem, [&](const FixedPatch::Sample& s) { return strip_stiffness(s, axis, problem.tool); },
        [](const FixedPatch& patch, std::size_t row) { return patch.row_length()[row]; });
}

std::optional<double> passes_within_margins(const FixedProblem& problem, const Vec3& axis) {
    const double cos_least = std::cos(problem.margins.least_inclination),
                 cos_greatest = std::cos(problem.margins.greatest_inclination);
    for (const auto* all : {&problem.patches, &problem.guards})
        for (const FixedPatch& patch : *all)
            for (const FixedPatch::Sample& s : patch.samples())
                if (!keeps(s, axis, problem, cos_least, cos_greatest)) return std::nullopt;
    const double n = passes_needed(problem, axis);
    if (!std::isfinite(n)) return std::nullopt;
    return n;
}

}  // namespace trunnion
