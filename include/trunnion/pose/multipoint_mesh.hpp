// Two-point positioning on triangle meshes: the same two rays, in closed form per facet, edge and vertex.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "trunnion/pose/multipoint.hpp"

namespace trunnion {

/// Holds the triangles in a tree of boxes, each with a plane over them. Immutable and thread-safe.
class MeshPositioner {
public:
    /// `faces`: those of the part whose triangles count; empty = all. Error: as MultipointSolver::build.
    static Result<MeshPositioner> build(const Mesh& mesh, const std::vector<int>& faces, const Cutter& cutter,
                                        const MultipointOptions& options);

    /// Height of the torus centre along the drop axis at which the cutter over the footprint (x, y) rests on the mesh, and where.
    /// Accuracy: 1e-10 mm. Error: no_solution (NoSurfaceUnderTool).
    struct Rest {
        double z_c = 0.0;
        Vec3 P = Vec3::Zero();
        MultipointContact kind = MultipointContact::vertex;
        std::uint32_t triangle = 0;
    };
    Result<Rest> rest(double x, double y) const;

    /// Both contacts; as MultipointSolver::drop. P_uv and Q_uv are NaN, P_face the triangle's face. Nothing is certified beyond
    /// the closed forms: `certified_gouge` is 0 for the features of the mesh. Only the tilt away from P is known (tilt_minus =
    /// 0).
    Result<MultipointPose> drop(double x, double y, const Vec3& feed = Vec3::Zero()) const;
    Result<std::vector<Result<MultipointPose>>> drop_all(std::span<const Vec2> footprints, std::span<const Vec3> feeds,
                                                         const Control& control) const;

    double R_major() const;
    double R_minor() const;

    struct Impl;

private:
    explicit MeshPositioner(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
    std::shared_ptr<const Impl> impl_;
};

}  // namespace trunnion
