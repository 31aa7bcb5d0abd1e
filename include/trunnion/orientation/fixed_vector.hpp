#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// One direction everywhere: what a machine with its rotary axes clamped does.
struct FixedVector {
    static constexpr std::string_view name = "vector";
    Vec3 axis = Vec3::UnitZ();  ///< WCS, unit, tip to spindle
    /// Error: invalid_input for a zero direction; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
