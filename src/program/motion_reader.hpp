// Where the words of a program put the tool: what the readers of real controls share (private). Nothing here knows a writer.
#pragma once

#include <bitset>
#include <optional>

#include <fmt/format.h>

#include "program/text.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::detail {

/// What the linear words of a block mean.
enum class Meaning {
    machine,     ///< positions of the axes
    tip_axes,    ///< tool tip in the WCS, the tool axis by rotary words
    tip_vector,  ///< tool tip in the WCS, the tool axis as a vector
    plane        ///< tool tip in a tilted plane
};

/// Unit vectors of four decimals are within this of length 1; beyond it the three numbers are not meant as one.
inline constexpr double kVectorLengthSlack = 1e-3;

/// The words of one motion block.
struct Move {
    std::array<double, 5> value{};  ///< mm, degrees
    std::bitset<5> has;
    Vec3 vector = Vec3::Zero();
    std::bitset<3> has_vector;
    bool machine_coordinates = false, rapid = false, inverse_time = false;
    double feed = 0.0;  ///< mm/min or 1/min

    bool any() const { return has.any() || has_vector.any(); }
};

class MotionReader {
public:
    MotionReader(const Machine& machine, double tool_length, std::string dialect) : machine_(machine), tool_length_(tool_length) {
        program_.dialect = std::move(dialect);
    }

    int line = 0;

    tl::unexpected<Error> wrong(std::string_view what) const {
        return fail(ErrorCode::unreadable, fmt::format("line {}: {}", line, what));
    }
    const Machine& machine() const { return machine_; }
    Meaning meaning() const { return meaning_; }
    /// Index 0..4 of a machine's axis in tool-centre-point words (X Y Z are the WCS) or machine words; -1 if it has none.
    int axis_of(char letter) const {
        for (int j = 0; j < 2; ++j)
            if (machine_.rotary[j].letter == letter) return 3 + j;
        for (int j = 0; j < 3; ++j)
            if ((meaning_ == Meaning::machine ? machine_.linear[j].letter : "XYZ"[j]) == letter) return j;
        return -1;
    }

    /// The linear words mean something else from here on; rotary words stay where they are.
    void set_meaning(Meaning meaning, const Mat3& plane = Mat3::Identity()) {
        if (meaning != meaning_ || meaning == Meaning::plane)
            for (int j = 0; j < 3; ++j) known_.reset(j);
        vector_known_ = vector_known_ && meaning == Meaning::tip_vector;
        meaning_ = meaning;
        plane_ = plane;
    }
    void set_interpolation(Interpolation interpolation) { interpolation_ = interpolation; }

    Result<void> move(const Move& m) {
        if (m.has_vector.any() && meaning_ != Meaning::tip_vector)
            return wrong("a tool axis as a vector, but the mode that reads it is not switched on");
        if (meaning_ == Meaning::tip_vector && (m.has[3] || m.has[4]))
            return wrong(
                fmt::format("rotary word {} while the tool axis is given as a vector", machine_.rotary[m.has[3] ? 0 : 1].letter));
        const std::array<double, 5> last = position_;
        const Vec3 last_vector = vector_;
        const bool knew = complete();
        for (int j = 0; j < 5; ++j) {
            if (!m.has[j]) continue;
            position_[j] = m.value[j];
            // Machine coordinates: where that is in the work depends on offsets that the program does not hold.
            known_.set(j, !m.machine_coordinates || j >= 3);
        }
        if (m.has_vector.any()) {
            // A missing one of the three is zero.
            const double length = m.vector.norm();
            if (!(std::abs(length - 1.0) <= kVectorLengthSlack))
                return wrong(fmt::format("the tool axis ({:g}, {:g}, {:g}) has length {:.6g}, it must be 1", m.vector.x(),
                                         m.vector.y(), m.vector.z(), length));
            vector_ = m.vector / length;
            vector_known_ = true;
        }
        if (m.machine_coordinates || !complete()) return {};
        if (!m.rapid && !(m.feed > 0)) return wrong("a cutting move without a feed");

        ProgramBlock block;
        block.line = line;
        block.rapid = m.rapid;
        const Vec3 linear(position_[0], position_[1], position_[2]);
        const double first = radians(position_[3]), second = radians(position_[4]);
        if (meaning_ == Meaning::tip_vector) {
            block.tip = {linear, vector_};
        } else {
            block.has_joints = true;
            const Vec3 tip = plane_ * linear;
            block.joints = meaning_ == Meaning::machine ? JointPosition{linear.x(), linear.y(), linear.z(), first, second}
                                                        : joints_at(machine_, tip, first, second, tool_length_);
            block.tip = forward(machine_, block.joints, tool_length_);
            if (meaning_ != Meaning::machine) block.tip.cl = tip;
            if (meaning_ == Meaning::plane) {
                const double off = angle_between(block.tip.axis, plane_.col(2));
                if (!(off <= kPlaneSlack))
                    return wrong(fmt::format("the plane leans {:.5f} deg from the tool axis at {}{:g} {}{:g}", degrees(off),
                                             machine_.rotary[0].letter, position_[3], machine_.rotary[1].letter, position_[4]));
            }
        }
        if (program_.blocks.empty()) {
            program_.tcp = meaning_ != Meaning::machine;
            program_.interpolation = meaning_ == Meaning::machine ? Interpolation::all_axes : interpolation_;
            first_meaning_ = meaning_;
        }
        if (meaning_ != first_meaning_) return wrong("a move after the control's mode was switched in the middle of the program");
        if (!m.rapid && knew && !program_.blocks.empty()) set_feed(block, m, last, last_vector);
        program_.blocks.push_back(block);
        return {};
    }

    Result<ProgramText> finish() {
        if (program_.blocks.empty())
            return wrong(fmt::format("the program never states a whole position (X Y Z and {} {}, or a tool axis)",
                                     machine_.rotary[0].letter, machine_.rotary[1].letter));
        return std::move(program_);
    }
    void reserve(std::size_t blocks) { program_.blocks.reserve(blocks); }

private:
    /// A plane's angles have at least four decimals of a degree, and so have the rotary words.
    static constexpr double kPlaneSlack = radians(5e-4);

    bool complete() const {
        return known_[0] && known_[1] && known_[2] && (meaning_ == Meaning::tip_vector ? vector_known_ : known_[3] && known_[4]);
    }
    /// Under tool-centre-point control F is the speed of the tip, and degrees per minute where the tip rests.
    void set_feed(ProgramBlock& block, const Move& m, const std::array<double, 5>& last, const Vec3& last_vector) const {
        double moved = 0.0, turned = 0.0;
        for (int j = 0; j < 3; ++j) moved += (position_[j] - last[j]) * (position_[j] - last[j]);
        for (int j = 3; j < 5; ++j) turned += (position_[j] - last[j]) * (position_[j] - last[j]);
        if (m.inverse_time) {
            block.seconds = 60.0 / m.feed;
            block.feed = (block.tip.cl - program_.blocks.back().tip.cl).norm() / block.seconds;
        } else if (moved > 0.0) {
            block.feed = m.feed / 60.0;
        } else {
            const double angle =
                meaning_ == Meaning::tip_vector ? degrees(angle_between(last_vector, vector_)) : std::sqrt(turned);
            block.seconds = angle * 60.0 / m.feed;
        }
    }

    const Machine& machine_;
    double tool_length_;
    ProgramText program_;
    Meaning meaning_ = Meaning::machine, first_meaning_ = Meaning::machine;
    Interpolation interpolation_ = Interpolation::rotary_axes;
    Mat3 plane_ = Mat3::Identity();
    std::array<double, 5> position_{};
    std::bitset<5> known_;
    Vec3 vector_ = Vec3::UnitZ();
    bool vector_known_ = false;
};

}  // namespace trunnion::detail
