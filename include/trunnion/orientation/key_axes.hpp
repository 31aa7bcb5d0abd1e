#pragma once

#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// Axes given at places along every pass, and great circles between them. Before the first and after the last one it stands
/// still.
struct KeyAxes {
    static constexpr std::string_view name = "keys";
    struct Key {
        double at = 0.0;            ///< fraction of the pass's length, from 0 to 1
        Vec3 axis = Vec3::UnitZ();  ///< WCS, unit
    };
    std::vector<Key> keys{{0.0, Vec3::UnitZ()}};  ///< ascending
    /// Error: invalid_input without keys, for keys out of order or a zero direction; no_solution between opposite axes;
    /// cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
