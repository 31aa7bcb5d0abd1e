// How many passes a patch needs with one fixed tool axis, and the axis that needs fewest. Source: fixed-axis sheet, sections 3,
// 4, 6 and 12; Zhu, Chen, Ning, Xu, "Tool orientation optimization for 3+2-axis CNC machining of sculptured surface" (2016).
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/part/part.hpp"
#include "trunnion/path/strip.hpp"

namespace trunnion {

/// What the estimate knows of a cutter. mm.
struct FixedTool {
    double R_major = 0.0, r = 0.0;  ///< of the torus; a ball has R_major = 0, a flat end r = 0
    double scallop = 0.02;          ///< h
    /// Error: unsupported for cutters that are not ball, flat or bull with a closed bottom.
    static Result<FixedTool> from(const Cutter& cutter, double scallop);
};

/// Part of the problem, not of its solution: optima often lie on them (sheet, section 12).
struct FixedMargins {
    double least_inclination = radians(3.0);       ///< rad, from every normal; a ball needs none
    double greatest_inclination = radians(88.85);  ///< rad
    double least_curvature = 0.005;                ///< 1/mm, K_MARGIN: by how much the cutter is more curved than the surface
};

/// A patch as samples in rows (one pass each): of N samples each holds its frame (f, b, n), the surface's form along (f, b) and
/// how many mm across the feed one whole range of the fixed parameter is.
class FixedPatch {
public:
    struct Sample {
        Vec3 n, f, b;
        TangentForm form;     ///< Qs
        double across = 0.0;  ///< mm
        double area = 0.0;    ///< mm2 of its cell
    };
    struct Grid {
        int rows = 25, columns = 25;
        bool midpoints = true;  ///< rows at the middles of their bands (a quadrature); otherwise from end to end
    };
    /// Samples the kept part of a face, passes along u or along v. Error: unsupported for a face without a surface; no_solution
    /// if the trimming leaves no sample or the surface is degenerate at one (says where).
    static Result<FixedPatch> of(const Face& face, bool along_u, const Grid& grid);

    const std::vector<Sample>& samples() const { return samples_; }
    const std::vector<std::size_t>& row_end() const { return row_end_; }   ///< per row: one past its last sample
    const std::vector<double>& row_length() const { return row_length_; }  ///< mm, of the iso-line that is kept

private:
    std::vector<Sample> samples_;
    std::vector<std::size_t> row_end_;
    std::vector<double> row_length_;
};

/// The patches to machine with one axis, and the same patches sampled finely for the margins.
struct FixedProblem {
    std::vector<FixedPatch> patches, guards;
    FixedTool tool;
    FixedMargins margins;

    /// 25 x 25 samples a face (101 rows where it is trimmed), margins on 81 x 81. Error: of FixedPatch::of, with the face.
    static Result<FixedProblem> of(const std::vector<const Face*>& faces, bool along_u, const FixedTool& tool,
                                   const FixedMargins& margins);
    Vec3 mean_normal() const;  ///< area-weighted, unit: Y of the sheet
};

/// 1/(Q^-1)_22 (1/mm): the strip is sqrt(8 h / it) wide, to second order. Negative where Q is not positive definite.
double strip_stiffness(const FixedPatch::Sample& sample, const Vec3& axis, const FixedTool& tool);

/// N(T) = integral dv / min_u w(u, v; T), summed over the patches (sheet, section 6, the law behind the paper's Eqs 3-6),
/// whatever the margins. Infinite where the cutter is flatter than the surface somewhere or the axis is not above it.
double passes_needed(const FixedProblem& problem, const Vec3& axis);
/// The same with every cross-feed width measured in the section of the standing cutter: up to 73 % more. To show, not to use.
double passes_by_section(const FixedProblem& problem, const Vec3& axis);
/// L(T) = integral l(v) / min_u w dv, mm: the passes' length without making them.
double length_needed(const FixedProblem& problem, const Vec3& axis);
/// Nothing where a margin is violated at a sample of a patch or of a guard.
std::optional<double> passes_within_margins(const FixedProblem& problem, const Vec3& axis);

struct FixedSearch {
    int directions = 4000;       ///< of the hemisphere about the mean normal
    double gap = 0.002;          ///< relative, between the best axis and the certified bound, where the search may stop
    std::size_t cells = 60'000;  ///< at most, of the certificate
};
struct FixedBest {
    Vec3 axis = Vec3::UnitZ();
    double passes = 0.0;       ///< N to second order
    double lower_bound = 0.0;  ///< no axis within the margins needs fewer, of the sampled N: proved
    std::size_t cells = 0;     ///< that the proof took
};
/// The whole sphere: dense directions, pattern search from the best ones 8 deg apart, then branch and bound over cells of axes,
/// which proves the bound and replaces the axis by any better one it meets. `clear` says whether the tool may stand so everywhere
/// (holder, neighbours, travel); empty = always. Interference can only make the bound loose, never wrong. Deterministic.
/// Error: cancelled; no_solution where no axis was found, with what stands against it.
Result<FixedBest> find_fixed_axis(const FixedProblem& problem, const std::function<bool(const Vec3&)>& clear,
                                  const FixedSearch& options, const Control& control);

}  // namespace trunnion
