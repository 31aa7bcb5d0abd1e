// The kinematic chain with everything that does not depend on the joints worked out once: for loops over many poses.
#pragma once

#include <array>
#include <cmath>

#include "trunnion/machine/machine.hpp"

namespace trunnion::detail {

/// Within this angle (rad) of the outer rotary axis a tool axis given in double precision no longer determines the turn
/// about it: one ulp of the tool axis is more than 1e-6 rad of turn.
inline constexpr double kPoleAngle = 1e-10;
/// Along a path the same, with room for tool axes that went through a file of seven decimals: such an axis is held at
/// the pole, which moves the tip not at all and the tool axis by less than a nanometre on 10 mm.
inline constexpr double kPathPoleAngle = 1e-7;
/// How far (rad) beyond the reachable cone an axis may lie and still be taken as on its edge: 8 ulp of pi.
inline constexpr double kReachAngle = 8 * 2.2204460492503131e-16 * kPi;

struct CosSin {
    double c = 1.0, s = 0.0;
    static CosSin of(double angle) { return {std::cos(angle), std::sin(angle)}; }
};

/// v turned about the unit vector k (Rodrigues).
inline Vec3 turned(const Vec3& v, const Vec3& k, const CosSin& a) {
    return a.c * v + a.s * k.cross(v) + ((1.0 - a.c) * k.dot(v)) * k;
}

/// Where the rotary words put things. One object per pair of rotary words.
class Turned {
public:
    Turned(const Machine& machine, double word_1, double word_2)
        : Turned(machine, {CosSin::of(machine.rotary[0].sign * word_1), CosSin::of(machine.rotary[1].sign * word_2)}) {}
    /// By cosine and sine of sign * word.
    Turned(const Machine& machine, const std::array<CosSin, 2>& turn) : machine_(machine), turn_(turn) {}

    /// From the gauge point at zero to the tip, MCS.
    Vec3 reach(double tool_length) const {
        Vec3 x = -tool_length * machine_.spindle;
        for (const int i : {1, 0})
            if (is(i, Side::head)) x = about(i, x, turn_[i]);
        return x;
    }
    /// A point of the work, WCS, in the machine.
    Vec3 placed(const Vec3& work) const {
        Vec3 x = work + machine_.work_offset;
        for (const int i : {1, 0})
            if (is(i, Side::table)) x = about(i, x, turn_[i]);
        return x;
    }
    /// The inverse of placed().
    Vec3 on_work(const Vec3& point) const {
        Vec3 x = point;
        for (const int i : {0, 1})
            if (is(i, Side::table)) x = about(i, x, {turn_[i].c, -turn_[i].s});
        return x - machine_.work_offset;
    }
    /// Tool axis in the WCS.
    Vec3 axis() const {
        Vec3 x = machine_.spindle;
        for (const int i : {1, 0})
            if (is(i, Side::head)) x = turned(x, machine_.rotary[i].direction, turn_[i]);
        for (const int i : {0, 1})
            if (is(i, Side::table)) x = turned(x, machine_.rotary[i].direction, {turn_[i].c, -turn_[i].s});
        return x;
    }

private:
    bool is(int i, Side side) const { return machine_.rotary[i].side == side; }
    Vec3 about(int i, const Vec3& x, const CosSin& a) const {
        const RotaryAxis& axis = machine_.rotary[i];
        return turned(x - axis.point, axis.direction, a) + axis.point;
    }
    const Machine& machine_;
    std::array<CosSin, 2> turn_;
};

/// Columns: directions of the linear axes.
inline Mat3 linear_directions(const Machine& machine) {
    Mat3 d;
    for (int i = 0; i < 3; ++i) d.col(i) = machine.linear[i].direction;
    return d;
}

/// The two pairs of rotary words for a tool axis.
struct RotarySolutions {
    std::array<std::array<double, 2>, 2> words{};  ///< [solution][rotary axis], each in (-pi, pi]
    double sine = 1.0;                             ///< as InverseSolution::sine; the same for both
    double sin_tilt = 0.0, cos_tilt = 1.0;         ///< of the angle between the outer axis and the tool axis
    bool reachable = false;
    bool free = false;  ///< the tool axis is parallel to the outer axis: its word is free (0 here)
};

/// The same with what the linear axes need of them; not kept for every pose, memory costs more than working it out again.
struct SolvedPose {
    RotarySolutions rotary;
    std::array<std::array<CosSin, 2>, 2> turn{};  ///< [solution][rotary axis], of sign * word
};

/// The tool axis is T = R(a, angle_a) R(b, angle_b) s for every arrangement of head and table, where a, the outer axis,
/// is the one nearest the work in the chain work -> tool, and a table turns the tool axis by minus its own turn.
class Chain {
public:
    explicit Chain(const Machine& machine);

    const Machine& machine() const { return machine_; }
    int outer() const { return outer_; }  ///< index of a in Machine::rotary
    int inner() const { return 1 - outer_; }
    /// Angles between a and T that the machine can reach.
    Interval tilt_range() const { return {least_tilt_, most_tilt_}; }

    /// Source: Paden and Kahan's second subproblem, solved as the spherical triangle (a, b, v) with v = R(b, angle_b) s,
    /// by half-angle formulas, which keep full accuracy at the pole and at the edge of the reachable cone.
    /// An axis up to `reach_slack` (rad) outside the cone gets the words of the nearest edge.
    SolvedPose solve(const Vec3& axis, double pole_angle, double reach_slack) const;

    Vec3 linear_words(const Turned& turned, const Vec3& cl, double tool_length) const {
        return from_mcs_ * (turned.placed(cl) - turned.reach(tool_length));
    }

private:
    Machine machine_;
    Mat3 from_mcs_;  // MCS -> linear words
    int outer_ = 0;
    Vec3 a_, p_, q_;                      // frame about a: p towards b
    double sign_a_ = 1.0, sign_b_ = 1.0;  // angle = sign * word
    double side_a_ = 1.0, side_b_ = 1.0;  // angle = side * (what the axis carries turns): -1 for a table
    double sin_ab_, cos_ab_, sin_bs_;     // angle between a and b; between b and the spindle
    double sin_difference_;               // of (a,b) - (b,s)
    CosSin spindle_turn_;                 // of the azimuth of s about b, from the plane (a, b)
    CosSin half_difference_, half_sum_;   // of (a,b) -+ (b,s)
    double least_tilt_, most_tilt_;
    double spindle_azimuth_;  // of s about b, from the plane (a, b)
};

/// The nearest whole number, for |x| < 2^51: adding 1.5 * 2^52 leaves no room for a fraction. std::nearbyint is a call of the
/// library on the oldest machines that we build for.
inline double nearest_whole(double x) {
    constexpr double kNoFraction = 6755399441055744.0;
    return (x + kNoFraction) - kNoFraction;
}

/// x moved by whole turns into (-pi, pi].
inline double principal(double x) {
    const double y = x - 2 * kPi * nearest_whole(x * (0.5 / kPi));
    return y <= -kPi ? y + 2 * kPi : y;
}

}  // namespace trunnion::detail
