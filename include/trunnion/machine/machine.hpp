// A five-axis machine: its kinematic chain as data, forward beside inverse, limits.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion {

enum class Side { head, table };

struct AxisLimits {
    double lo = 0.0, hi = 0.0;  ///< mm or rad, of the axis word
    double velocity = 0.0;      ///< mm/s or rad/s, > 0
    double acceleration = 0.0;  ///< mm/s2 or rad/s2, > 0
    double jerk = 0.0;          ///< mm/s3 or rad/s3, 0 = unlimited
};

struct LinearAxis {
    char letter = 'X';
    Vec3 direction = Vec3::UnitX();  ///< MCS, unit: the tool moves this way against the work for a growing word
    AxisLimits limits;
};

/// Rotation about a line fixed in the machine when all axes stand at zero.
/// turn(word) rotates what the axis carries (head: the tool, table: the work) by `sign * word` about `direction`
/// through `point`, right-handed. sign states the control's convention (ISO 841: a table has sign -1; LinuxCNC's trt: +1).
struct RotaryAxis {
    char letter = 'A';
    Side side = Side::table;
    Vec3 direction = Vec3::UnitX();  ///< MCS, unit
    Vec3 point = Vec3::Zero();       ///< MCS, mm. For a head axis: relative to the spindle gauge point at zero
    double sign = 1.0;               ///< +1 or -1
    AxisLimits limits;
};

/// The chain. With all rotary axes at zero the linear words name the spindle gauge point:
/// tip + tool_length * spindle = X dir_X + Y dir_Y + Z dir_Z, in the MCS. Table axes are ordered from the base to the work, head
/// axes from the slide to the spindle; with one of each the order between them does not matter. Linear axes are below all rotary
/// ones.
struct Machine {
    std::string name, title;
    std::array<LinearAxis, 3> linear;
    std::array<RotaryAxis, 2> rotary;
    Vec3 spindle = Vec3::UnitZ();     ///< tool axis (tip to spindle) with the rotary axes at zero, MCS
    Vec3 work_offset = Vec3::Zero();  ///< WCS origin in the MCS with all axes at zero (WCS parallel to MCS)
    double rapid = 0.0;               ///< mm/s along the path on links, > 0
    bool tcp = true;                  ///< the control offers tool-centre-point control
    std::string source;               ///< file or "built-in"
};

/// Axis words: X Y Z in mm, rotary 1 and 2 in radians (words as the control understands them, unwrapped).
using JointPosition = std::array<double, 5>;

struct TipPose {
    Vec3 cl;    ///< WCS, tool tip
    Vec3 axis;  ///< WCS, unit
};

/// Tool tip and axis in the WCS for the given joints and tool length (gauge point to tip, mm). Closed form.
TipPose forward(const Machine& machine, const JointPosition& joints, double tool_length);

/// Axis words that put the tip at cl (WCS) when the rotary words are given.
JointPosition joints_at(const Machine& machine, const Vec3& cl, double rotary_1, double rotary_2, double tool_length);

/// One way to reach a pose. `singular`: the axis direction does not determine one rotary angle (it is then free; the
/// returned one is 0). `sine`: 1/sine is the most that a rotary axis turns per radian of the tool axis, so it vanishes
/// at the pole (tool axis along the outer rotary axis) and at the edge of the cone that the machine can reach.
struct InverseSolution {
    JointPosition joints;
    double sine = 1.0;
    bool singular = false;
};

/// Both solutions, rotary words in (-pi, pi]; fewer than two only if the axis cannot be reached (none) or the two coincide.
/// Travel limits are not looked at. Requires: rotary axes not parallel, spindle not along the axis that carries it.
std::vector<InverseSolution> inverse(const Machine& machine, const Vec3& cl, const Vec3& axis, double tool_length);

/// Error: invalid_input with file and line: missing or zero axis, parallel rotary axes, crossed travel, unknown key...
Result<Machine> machine_from_toml(std::string_view text, std::string_view source);
Result<Machine> load_machine(const std::filesystem::path& file);
/// Built-in machine by name. Error: not_found naming the nearest one.
Result<Machine> built_in_machine(std::string_view name);
std::vector<std::string> built_in_machine_names();

}  // namespace trunnion
