#include "machine/coverage.hpp"

#include <algorithm>

namespace trunnion::detail {

double deviation_bound(const Chain& chain, const RotaryMotion& motion, double end_error, double slack) {
    const double bend = bend_bound(chain, motion);
    // |f| is a chord between unit vectors; the angle is 2 asin(|f|/2).
    const auto angle = [](double chord) { return 2 * std::asin(std::min(1.0, chord / 2)); };
    double bound = angle(bend / 8) + end_error;
    for (const int pieces : {8, 64, 512}) {
        if (bound <= slack) return bound;
        double largest = 0.0;
        for (int k = 1; k < pieces; ++k) {
            const double t = static_cast<double>(k) / pieces;
            const Turned at(chain.machine(), std::lerp(motion.words[0], motion.next[0], t),
                            std::lerp(motion.words[1], motion.next[1], t));
            largest = std::max(largest, angle_between(at.axis(), slerp(motion.from, motion.to, t)));
            if (largest > slack) break;
        }
        const double remainder = bend / (8.0 * pieces * pieces);
        bound = std::min(kPi, std::max(largest, end_error) + 2 * std::asin(std::min(1.0, remainder / 2)));
        if (largest > slack) return bound;
    }
    return bound;
}

double tip_deviation_bound(const Chain& chain, const JointPosition& from, const JointPosition& to, double tool_length) {
    const Machine& machine = chain.machine();
    const double turn = std::abs(to[3] - from[3]) + std::abs(to[4] - from[4]);
    double move = 0.0, start = 0.0, end = 0.0;
    for (int i = 0; i < 3; ++i) {
        move += std::abs(to[i] - from[i]);
        start += std::abs(from[i]);
        end += std::abs(to[i]);
    }
    // Whatever is turned lies within this radius of the axis that turns it: linear axes, tool, pivots.
    const double radius =
        std::max(start, end) + tool_length + 2 * (machine.rotary[0].point.norm() + machine.rotary[1].point.norm());
    const double bend = turn * turn * radius + 2 * turn * move;

    constexpr int kPieces = 16;
    const Vec3 first = forward(machine, from, tool_length).cl, last = forward(machine, to, tool_length).cl;
    double largest = 0.0;
    for (int k = 1; k < kPieces && turn > 0; ++k) {
        const double t = static_cast<double>(k) / kPieces;
        JointPosition joints;
        for (int i = 0; i < 5; ++i) joints[i] = std::lerp(from[i], to[i], t);
        largest = std::max(largest, (forward(machine, joints, tool_length).cl - (first + t * (last - first))).norm());
    }
    return largest + bend / (8.0 * kPieces * kPieces);
}

}  // namespace trunnion::detail
