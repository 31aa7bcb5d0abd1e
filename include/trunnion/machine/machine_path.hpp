// A checked path as axis motion. Only the machine room can make one.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/check/checked_path.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {

struct MotionOptions {
    double feed = 25.0;             ///< mm/s of the tip on cuts (1500 mm/min)
    double lead_feed = 25.0;        ///< mm/s on lead-ins and lead-outs
    double tool_length = 0.0;       ///< mm, gauge point to tip
    double singular_sine = 0.0349;  ///< poses with a smaller sine are reported as near the singularity (2 deg)
    /// The program will run under tool-centre-point control. If not (or if the machine has none) all five axes move straight
    /// between the poses and the tip leaves its line: by how much is reported, and more than `tip_slack` is invalid.
    bool tcp = true;
    double tip_slack = std::numeric_limits<double>::infinity();  ///< mm
};

namespace detail {
struct MachinePathMaker;  // defined only inside src/machine
}

/// Immutable. Arrays of N = poses().size() entries.
class MachinePath {
public:
    const CheckedPath& checked() const { return checked_; }
    const PosePath& poses() const { return checked_.poses(); }
    const Machine& machine() const { return machine_; }
    const MotionOptions& options() const { return options_; }
    const std::vector<JointPosition>& joints() const { return joints_; }  ///< inside the travel where valid
    const std::vector<std::uint8_t>& branch() const { return branch_; }   ///< 0 or 1: which of the two solutions
    const std::vector<double>& feed() const {
        return feed_;
    }  ///< mm/s of the tip towards pose i, after axis limits; 0 where the tip rests
    const std::vector<double>& time() const { return time_; }  ///< s, when pose i is reached; time[0] = 0
    /// Empty where the pose may be posted; otherwise one sentence (check's, or: axis limit, unreachable, branch jump,
    /// motion not covered by the check).
    const std::vector<std::string>& why() const { return why_; }
    bool valid() const { return valid_; }
    /// By how many times the motion towards pose i strays beyond what is allowed: its axis from the checked great circle, and
    /// without tool-centre-point control its tip from the straight line. At most 1 where it is covered; falls with the square of
    /// the step where a motion is cut in pieces.
    const std::vector<double>& overstep() const { return overstep_; }
    /// Poses on whose way the axes would have to jump (turn round or change the solution), since no continuous branch stays
    /// inside the travel: as few as there can be, on links before cuts. There the tool has to go out and wind back.
    const std::vector<std::size_t>& jumps() const { return jumps_; }
    const std::vector<std::string>& warnings() const { return warnings_; }  ///< singular neighbourhoods, slow axes...

    struct Totals {
        double time = 0.0;                      ///< s
        double cut_length = 0.0, length = 0.0;  ///< mm of tip path
        std::array<double, 5> travel{};         ///< mm, rad: sum of moves per axis
        std::array<double, 5> top_speed{};      ///< mm/s, rad/s
        double least_sine = 1.0;
        std::size_t near_singular = 0;
        double axis_deviation = 0.0;  ///< rad, proved bound: joint motion off the great circle, over the covered motions
        double tip_deviation = 0.0;   ///< mm, proved bound: tip off its straight line; 0 under tool-centre-point control
    };
    const Totals& totals() const { return totals_; }

private:
    friend struct detail::MachinePathMaker;
    MachinePath(CheckedPath checked, Machine machine, MotionOptions options)
        : checked_(std::move(checked)), machine_(std::move(machine)), options_(options) {}
    CheckedPath checked_;
    Machine machine_;
    MotionOptions options_;
    std::vector<JointPosition> joints_;
    std::vector<std::uint8_t> branch_;
    std::vector<double> feed_, time_, overstep_;
    std::vector<std::string> why_, warnings_;
    std::vector<std::size_t> jumps_;
    Totals totals_;
    bool valid_ = false;
};

/// Axis motion of the whole path: one continuous branch chosen over all solutions and turns by dynamic programming
/// (least rotary travel inside the limits), unwrapped, timed from feed and axis velocities: a motion takes
/// max(tip length / feed, |move of an axis| / its velocity). Tool axes at the pole keep the rotary word of a neighbour.
/// A pose that cannot be reached, leaves the travel, or whose joint motion leaves the checked great circle by more than
/// checked.axis_slack(i) is marked invalid with its reason; it is not an error.
/// Error: cancelled; invalid_input for a feed or tool length that is not positive.
Result<MachinePath> move_machine(CheckedPath checked, const Machine& machine, const MotionOptions& options,
                                 const Control& control);

}  // namespace trunnion
