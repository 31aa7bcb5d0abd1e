#include <gtest/gtest.h>

#include "support/random_machine.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {
namespace {

double whole_turn_apart(double a, double b) {
    return std::abs(std::remainder(a - b, 2 * kPi));
}

/// The chain as homogeneous transforms multiplied out, straight from the description of the machine. Shares nothing with
/// the code under test but the data.
TipPose forward_by_matrices(const Machine& m, const JointPosition& q, double tool_length) {
    const auto about = [&](const RotaryAxis& axis, double word) {
        return Eigen::Translation3d(axis.point) * Eigen::AngleAxisd(axis.sign * word, axis.direction) *
               Eigen::Translation3d(-axis.point);
    };
    Frame slide = Frame::Identity(), head = Frame::Identity(), table = Frame::Identity();
    for (int i = 0; i < 3; ++i) slide.translate(q[i] * m.linear[i].direction);
    for (int i = 0; i < 2; ++i)
        (m.rotary[i].side == Side::head ? head : table) =
            (m.rotary[i].side == Side::head ? head : table) * about(m.rotary[i], q[3 + i]);
    const Frame tool = table.inverse() * slide * head;
    return {tool * Vec3(-tool_length * m.spindle) - m.work_offset, tool.linear() * m.spindle};
}

TEST(Kinematics, ForwardIsTheProductOfTheTransformsOfTheChain) {
    MachineGenerator random(1);
    for (int k = 0; k < 2000; ++k) {
        const Machine m = random.machine();
        const JointPosition q{random.uniform(-500, 500), random.uniform(-500, 500), random.uniform(-500, 500),
                              random.uniform(-7, 7), random.uniform(-7, 7)};
        const TipPose ours = forward(m, q, 120), theirs = forward_by_matrices(m, q, 120);
        ASSERT_LT((ours.cl - theirs.cl).norm(), 1e-11) << "case " << k;
        ASSERT_LT((ours.axis - theirs.axis).norm(), 1e-14) << "case " << k;
    }
}

TEST(Kinematics, InverseFindsTheJointsThatMadeThePoseAndOneOtherWayToReachIt) {
    MachineGenerator random(2);
    double worst_tip = 0, worst_axis = 0;
    for (int k = 0; k < 20000; ++k) {
        const Machine m = random.machine();
        const JointPosition q{random.uniform(-500, 500), random.uniform(-500, 500), random.uniform(-500, 500),
                              random.uniform(-3.1, 3.1), random.uniform(-3.1, 3.1)};
        const TipPose pose = forward(m, q, 150);
        const auto solutions = inverse(m, pose.cl, pose.axis, 150);
        ASSERT_EQ(solutions.size(), 2u) << "case " << k;
        double nearest = 1e9;
        for (const auto& s : solutions) {
            const TipPose again = forward(m, s.joints, 150);
            worst_tip = std::max(worst_tip, (again.cl - pose.cl).norm());
            worst_axis = std::max(worst_axis, (again.axis - pose.axis).norm());
            double off = 0;
            for (int j = 3; j < 5; ++j) {
                off = std::max(off, whole_turn_apart(s.joints[j], q[j]));
                ASSERT_GT(s.joints[j], -kPi);
                ASSERT_LE(s.joints[j], kPi);
            }
            nearest = std::min(nearest, off * s.sine);
        }
        ASSERT_LT(nearest, 1e-13) << "case " << k;
    }
    EXPECT_LT(worst_tip, 1e-9);  // mm
    EXPECT_LT(worst_axis, 1e-12);
    RecordProperty("worst_tip_mm", std::to_string(worst_tip * 1e12) + "e-12");
}

TEST(Kinematics, SineIsTheInverseOfTheGreatestRotaryRate) {
    MachineGenerator random(3);
    for (int k = 0; k < 500; ++k) {
        const Machine m = random.machine();
        const JointPosition q{0, 0, 0, random.uniform(-3, 3), random.uniform(-3, 3)};
        const Vec3 axis = forward(m, q, 100).axis;
        const double sine = inverse(m, Vec3::Zero(), axis, 100).front().sine;
        // By differences: columns of d(axis)/d(words), then the largest row of their pseudo-inverse.
        constexpr double h = 1e-6;
        Eigen::Matrix<double, 3, 2> jacobian;
        for (int j = 0; j < 2; ++j) {
            JointPosition plus = q, minus = q;
            plus[3 + j] += h;
            minus[3 + j] -= h;
            jacobian.col(j) = (forward(m, plus, 100).axis - forward(m, minus, 100).axis) / (2 * h);
        }
        const double c00 = jacobian.col(0).squaredNorm(), c11 = jacobian.col(1).squaredNorm(),
                     c01 = jacobian.col(0).dot(jacobian.col(1));
        const double area = std::sqrt(c00 * c11 - c01 * c01);
        if (area < 1e-3) continue;
        const double rate = std::max(std::sqrt(c11), std::sqrt(c00)) / area;
        ASSERT_NEAR(sine * rate, 1.0, 1e-4) << "case " << k;
    }
}

TEST(Kinematics, AxesNearThePoleAndNearTheEdgeOfTheConeAreReachedToRounding) {
    MachineGenerator random(4);
    for (int k = 0; k < 4000; ++k) {
        Machine m = random.machine();
        // Pole reachable: the inner axis leans from the outer as the spindle does from it (as on 45 degree heads).
        const bool outer_first =
            m.rotary[0].side != m.rotary[1].side ? m.rotary[0].side == Side::table : m.rotary[0].side == Side::head;
        const Vec3 a = m.rotary[outer_first ? 0 : 1].direction;
        m.spindle = a;
        const double off = std::pow(10.0, random.uniform(-9.5, -1)), turn = random.uniform(-3, 3);
        const Vec3 side = any_perpendicular(a);
        const Vec3 pole = std::cos(off) * a + std::sin(off) * (std::cos(turn) * side + std::sin(turn) * a.cross(side));
        const auto at_pole = inverse(m, Vec3::Zero(), pole, 100);
        ASSERT_EQ(at_pole.size(), 2u) << "case " << k;
        for (const auto& s : at_pole) {
            ASSERT_LT((forward(m, s.joints, 100).axis - pole).norm(), 4e-15 + 1e-15) << "case " << k << " off " << off;
            ASSERT_FALSE(s.singular);
        }
        // Edge of the cone: the inner axis turned half way round from the pole, give or take little.
        JointPosition q{};
        q[outer_first ? 3 : 4] = turn;
        q[outer_first ? 4 : 3] = kPi - off;
        const Vec3 edge = forward(m, q, 100).axis;
        for (const auto& s : inverse(m, Vec3::Zero(), edge, 100))
            ASSERT_LT((forward(m, s.joints, 100).axis - edge).norm(), 1e-14);
        ASSERT_FALSE(inverse(m, Vec3::Zero(), edge, 100).empty());
    }
}

TEST(Kinematics, AtThePoleTheOuterWordIsFreeAndSaidToBe) {
    const Machine m = *built_in_machine("ac-table-table");
    const auto solutions = inverse(m, Vec3(1, 2, 3), Vec3::UnitZ(), 100);
    ASSERT_EQ(solutions.size(), 1u);
    EXPECT_TRUE(solutions[0].singular);
    EXPECT_LT(solutions[0].sine, 1e-15);
    EXPECT_EQ(solutions[0].joints[4], 0.0);
    EXPECT_LT((forward(m, solutions[0].joints, 100).cl - Vec3(1, 2, 3)).norm(), 1e-12);
}

TEST(Kinematics, ANutatedHeadReachesItsConeAndNothingElse) {
    Machine m = *built_in_machine("bc-head-head");
    m.rotary[1].direction = Vec3(0, 1, 1).normalized();  // 45 degrees: the tool leans from 0 to 90 degrees
    for (double lean : {0.01, 45.0, 89.99})
        EXPECT_EQ(inverse(m, Vec3::Zero(), Vec3(std::sin(radians(lean)), 0, std::cos(radians(lean))), 100).size(), 2u) << lean;
    for (double lean : {90.001, 120.0, 180.0})
        EXPECT_TRUE(inverse(m, Vec3::Zero(), Vec3(std::sin(radians(lean)), 0, std::cos(radians(lean))), 100).empty()) << lean;
}

// LinuxCNC's own formulas, typed from its documentation; q = programmed point + work offset + (0, 0, L).
struct Reference {
    Vec3 joints, axis;
};
Mat3 rx(double t) {
    return Eigen::AngleAxisd(t, Vec3::UnitX()).matrix();
}
Mat3 ry(double t) {
    return Eigen::AngleAxisd(t, Vec3::UnitY()).matrix();
}
Mat3 rz(double t) {
    return Eigen::AngleAxisd(t, Vec3::UnitZ()).matrix();
}

void expect_agreement(const Machine& m, double length,
                      const std::function<Reference(const Vec3& q, double first, double second)>& linuxcnc) {
    MachineGenerator random(5);
    for (int k = 0; k < 1000; ++k) {
        const Vec3 point = random.vector(300);
        const double first = random.uniform(-3, 3), second = random.uniform(-3, 3);
        const Reference expected = linuxcnc(point + m.work_offset + Vec3(0, 0, length), first, second);
        const JointPosition joints = joints_at(m, point, first, second, length);
        ASSERT_LT((Vec3(joints[0], joints[1], joints[2]) - expected.joints).norm(), 1e-11) << "case " << k;
        const TipPose pose = forward(m, joints, length);
        ASSERT_LT((pose.axis - expected.axis).norm(), 1e-14) << "case " << k;
        ASSERT_LT((pose.cl - point).norm(), 1e-11) << "case " << k;
    }
}

TEST(Kinematics, AgreesWithLinuxcncsXyzacTrunnion) {
    Machine m = *built_in_machine("linuxcnc-xyzac-trt");
    const Vec3 r(3, -4, 5), offset(0, 20, -15);
    m.rotary[0].point = r + offset;  // A
    m.rotary[1].point = r;           // C
    m.work_offset = {7, 8, 9};
    const double length = 110;
    expect_agreement(m, length, [&](const Vec3& q, double a, double c) {
        const Vec3 o = offset + Vec3(0, 0, length);
        return Reference{rx(a) * (rz(c) * (q - r) - o) + o + r,
                         {std::sin(c) * std::sin(a), std::cos(c) * std::sin(a), std::cos(a)}};
    });
}

TEST(Kinematics, AgreesWithLinuxcncsXyzbcTrunnion) {
    Machine m = *built_in_machine("linuxcnc-xyzbc-trt");
    const Vec3 r(3, -4, 5), offset(12, 0, -15);
    m.rotary[0].point = r + offset;  // B
    m.rotary[1].point = r;           // C
    const double length = 110;
    expect_agreement(m, length, [&](const Vec3& q, double b, double c) {
        const Vec3 o = offset + Vec3(0, 0, length);
        return Reference{ry(b) * (rz(c) * (q - r) - o) + o + r,
                         {-std::cos(c) * std::sin(b), std::sin(c) * std::sin(b), std::cos(b)}};
    });
}

TEST(Kinematics, AgreesWithLinuxcncs5axisHead) {
    const Machine m = *built_in_machine("linuxcnc-5axis");
    const double length = 110, pivot = 250 + length;
    expect_agreement(m, length, [&](const Vec3& q, double c, double b) {
        const Vec3 axis(-std::sin(b) * std::cos(c), -std::sin(b) * std::sin(c), std::cos(b));
        return Reference{q + pivot * (axis - Vec3::UnitZ()), axis};
    });
}

TEST(Kinematics, AgreesWithLinuxcncsXyzabTableWhoseSignsFollowIso) {
    Machine m = *built_in_machine("ac-table-table");
    const Vec3 r(3, -4, 5), offset(12, 0, -15);
    m.rotary[0] = {'B', Side::table, Vec3::UnitY(), r, -1, m.rotary[0].limits};
    m.rotary[1] = {'A', Side::table, Vec3::UnitX(), r + offset, -1, m.rotary[0].limits};
    const double length = 110;
    expect_agreement(m, length, [&](const Vec3& q, double b, double a) {
        const Vec3 le(0, 0, length);
        return Reference{ry(-b) * (rx(-a) * (q - r - le - offset) + offset) + r + le,
                         {std::sin(b), -std::sin(a) * std::cos(b), std::cos(a) * std::cos(b)}};
    });
}

TEST(Kinematics, AgreesWithLinuxcncsMaxHeadAndTable) {
    Machine m = *built_in_machine("b-head-c-table");
    m.rotary[0].sign = -1;  // B leans towards -X there
    m.rotary[0].point = {0, 0, 180};
    const double length = 110, pivot = 180 + length;
    expect_agreement(m, length, [&](const Vec3& q, double b, double c) {
        return Reference{rz(-c) * q + pivot * (Vec3(-std::sin(b), 0, std::cos(b)) - Vec3::UnitZ()),
                         {-std::cos(c) * std::sin(b), -std::sin(c) * std::sin(b), std::cos(b)}};
    });
}

}  // namespace
}  // namespace trunnion
