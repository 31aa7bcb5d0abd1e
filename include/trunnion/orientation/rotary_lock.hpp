#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

struct ContactPath;
struct Scene;

/// One rotary axis of the machine stands at a fixed angle; the other one brings the tool as near to a lead and tilt as it can.
/// The axes that are left form a cone about `pole`.
struct RotaryLock {
    static constexpr std::string_view name = "lock";
    char letter = 'A';              ///< of the axis that stands still
    double angle = 0.0;             ///< rad, its word
    double lead = 0.0, tilt = 0.0;  ///< rad, wanted, in (-pi/2, pi/2)
    /// All axes that the machine has left: T . pole = cosine. Follows from letter, angle and machine, which plan() knows.
    struct Cone {
        Vec3 pole = Vec3::UnitZ();
        double cosine = 0.0;
    };
    std::optional<Cone> cone{};
    /// Error: invalid_input without a cone, or for an angle of 90 deg or more; cancelled.
    Result<std::vector<Vec3>> operator()(const ContactPath& path, const Scene& scene, const Control& control) const;
};

}  // namespace trunnion
