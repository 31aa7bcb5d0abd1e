#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// Parallel to the normals of a second surface, each taken at its point nearest to the contact: a smooth guide beside a part that
/// is not.
struct SurfaceNormals {
    static constexpr std::string_view name = "normals";
    int face = -1;                   ///< of the part, with a surface; or
    std::optional<Surface> surface;  ///< one of its own
    bool reversed = false;           ///< against the normals
    /// Nearest point: the best of a grid of 65 x 65, then Newton steps to rounding. Error: invalid_input without a surface;
    /// no_solution where the nearest point has no normal; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
