#include <algorithm>

#include <Eigen/LU>

#include "machine/chain.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {
namespace detail {

Chain::Chain(const Machine& machine) : machine_(machine), from_mcs_(linear_directions(machine).inverse()) {
    // Two axes on the same side: the last of a table and the first of a head stand nearest the work in T's product.
    const auto side = [&](int i) { return machine.rotary[i].side; };
    if (side(0) == side(1))
        outer_ = side(0) == Side::table ? 1 : 0;
    else
        outer_ = side(0) == Side::table ? 0 : 1;
    const RotaryAxis& outer = machine.rotary[outer_];
    const RotaryAxis& inner = machine.rotary[1 - outer_];
    side_a_ = outer.side == Side::table ? -1.0 : 1.0;
    side_b_ = inner.side == Side::table ? -1.0 : 1.0;
    sign_a_ = side_a_ * outer.sign;
    sign_b_ = side_b_ * inner.sign;

    a_ = outer.direction;
    const Vec3 b = inner.direction, s = machine.spindle;
    sin_ab_ = a_.cross(b).norm();
    cos_ab_ = a_.dot(b);
    sin_bs_ = b.cross(s).norm();
    TRUNNION_REQUIRE(sin_ab_ > 0 && sin_bs_ > 0);
    p_ = (b - cos_ab_ * a_) / sin_ab_;
    q_ = a_.cross(p_);
    const Vec3 p_about_b = (a_ - cos_ab_ * b) / sin_ab_, q_about_b = b.cross(p_about_b);
    spindle_azimuth_ = std::atan2(s.dot(q_about_b), s.dot(p_about_b));
    spindle_turn_ = CosSin::of(spindle_azimuth_);

    const double omega = std::atan2(sin_ab_, cos_ab_), psi = std::atan2(sin_bs_, b.dot(s));
    sin_difference_ = std::sin(omega - psi);
    half_difference_ = CosSin::of((omega - psi) / 2);
    half_sum_ = CosSin::of((omega + psi) / 2);
    least_tilt_ = std::abs(omega - psi);
    most_tilt_ = kPi - std::abs(kPi - omega - psi);
}

SolvedPose Chain::solve(const Vec3& axis, double pole_angle, double reach_slack) const {
    SolvedPose solved;
    RotarySolutions& found = solved.rotary;
    // The tilt of T against a, and cosine and sine of its half, in the frame (p, q, a).
    const double along_p = axis.dot(p_), along_q = axis.dot(q_);
    found.sin_tilt = std::sqrt(along_p * along_p + along_q * along_q);
    found.cos_tilt = axis.dot(a_);
    CosSin half;
    if (found.cos_tilt >= 0) {
        half.c = std::sqrt((1.0 + found.cos_tilt) / 2);
        half.s = found.sin_tilt / (2 * half.c);
    } else {
        half.s = std::sqrt((1.0 - found.cos_tilt) / 2);
        half.c = found.sin_tilt / (2 * half.s);
    }

    // Triangle (a, b, v) with sides omega = (a, b), psi = (b, s), tilt. Sines of half of tilt -+ (omega - psi) and of half of
    // omega + psi -+ tilt: one is negative where the three sides make no triangle, by half the angle that is missing.
    const CosSin d = half_difference_, m = half_sum_;
    const double below = half.s * d.c - half.c * std::abs(d.s), above = half.s * d.c + half.c * std::abs(d.s);
    const double inside = m.s * half.c - m.c * half.s, around = m.s * half.c + m.c * half.s;
    if (!(below >= -reach_slack / 2 && inside >= -reach_slack / 2 && around >= -reach_slack / 2)) return solved;
    found.reachable = true;
    found.free = found.sin_tilt < pole_angle;

    // beta: angle at b, from sine and cosine squared of its half. Divided by their sum, which is 1 but for a clamped triangle.
    double sin2 = std::max(0.0, below * above), cos2 = std::max(0.0, inside * around);
    const double sum = sin2 + cos2;
    sin2 /= sum;
    cos2 /= sum;
    const double sin_beta = 2 * std::sqrt(sin2 * cos2), cos_beta = cos2 - sin2;
    const double beta = std::atan2(sin_beta, cos_beta);
    found.sine = sin_bs_ * sin_ab_ * sin_beta / std::max(sin_bs_, found.sin_tilt);

    // v seen about a: zeta on one side of the plane (a, b) for one solution, on the other for the other.
    const double zeta_q = sin_bs_ * sin_beta, zeta_p = sin_difference_ + 2 * sin_bs_ * cos_ab_ * sin2;
    const double zeta = found.free ? 0.0 : std::atan2(zeta_q, zeta_p), azimuth = found.free ? 0.0 : std::atan2(along_q, along_p);
    const double zeta_length = std::sqrt(zeta_p * zeta_p + zeta_q * zeta_q);
    const double scale = found.free ? 0.0 : 1.0 / (zeta_length * found.sin_tilt);
    for (const int solution : {0, 1}) {
        const double mirror = solution == 0 ? 1.0 : -1.0;
        found.words[solution][outer_] = principal(sign_a_ * (azimuth + mirror * zeta));
        found.words[solution][1 - outer_] = principal(sign_b_ * (mirror * beta - spindle_azimuth_));
        solved.turn[solution][outer_] = {(along_p * zeta_p - mirror * along_q * zeta_q) * scale,
                                         side_a_ * (along_q * zeta_p + mirror * along_p * zeta_q) * scale};
        solved.turn[solution][1 - outer_] = {cos_beta * spindle_turn_.c + mirror * sin_beta * spindle_turn_.s,
                                             side_b_ * (mirror * sin_beta * spindle_turn_.c - cos_beta * spindle_turn_.s)};
        if (found.free) solved.turn[solution][outer_] = {1.0, 0.0};
    }
    return solved;
}

}  // namespace detail

TipPose forward(const Machine& machine, const JointPosition& joints, double tool_length) {
    const detail::Turned turned(machine, joints[3], joints[4]);
    Vec3 gauge = Vec3::Zero();
    for (int i = 0; i < 3; ++i) gauge += joints[i] * machine.linear[i].direction;
    return {turned.on_work(gauge + turned.reach(tool_length)), turned.axis()};
}

JointPosition joints_at(const Machine& machine, const Vec3& cl, double rotary_1, double rotary_2, double tool_length) {
    const detail::Turned turned(machine, rotary_1, rotary_2);
    const Vec3 words = detail::linear_directions(machine).inverse() * (turned.placed(cl) - turned.reach(tool_length));
    return {words.x(), words.y(), words.z(), rotary_1, rotary_2};
}

std::vector<InverseSolution> inverse(const Machine& machine, const Vec3& cl, const Vec3& axis, double tool_length) {
    const detail::Chain chain(machine);
    const detail::RotarySolutions found = chain.solve(axis, detail::kPoleAngle, detail::kReachAngle).rotary;
    std::vector<InverseSolution> solutions;
    if (!found.reachable) return solutions;
    for (const auto& words : found.words) {
        const Vec3 linear = chain.linear_words(detail::Turned(machine, words[0], words[1]), cl, tool_length);
        solutions.push_back({{linear.x(), linear.y(), linear.z(), words[0], words[1]}, found.sine, found.free});
    }
    // At the edge of the cone the two become one; a whole turn apart is also the same place.
    const auto same = [&](int i) {
        return std::abs(detail::principal(found.words[0][i] - found.words[1][i])) < detail::kReachAngle;
    };
    if (same(0) && same(1)) solutions.pop_back();
    return solutions;
}

}  // namespace trunnion
