// Random five-axis machines: every arrangement of heads and tables, axes in general position.
#pragma once

#include <random>

#include "trunnion/machine/machine.hpp"

namespace trunnion {

class MachineGenerator {
public:
    explicit MachineGenerator(unsigned seed) : random_(seed) {}

    double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }
    Vec3 vector(double size) { return Vec3(uniform(-size, size), uniform(-size, size), uniform(-size, size)); }
    Vec3 direction() {
        while (true) {
            const Vec3 v = vector(1.0);
            if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
        }
    }
    /// At least 0.3 rad from parallel to `other`, either way.
    Vec3 direction_across(const Vec3& other) {
        while (true) {
            const Vec3 v = direction();
            if (v.cross(other).norm() > std::sin(0.3)) return v;
        }
    }
    Machine machine() {
        Machine m;
        m.name = "random";
        m.spindle = direction();
        m.work_offset = vector(100);
        const int kind = std::uniform_int_distribution<int>(0, 3)(random_);
        m.rotary[0].side = kind == 0 || kind == 2 ? Side::head : Side::table;
        m.rotary[1].side = kind == 0 || kind == 3 ? Side::head : Side::table;
        // Both across the spindle, so that whichever carries it does tilt the tool.
        m.rotary[0].direction = direction_across(m.spindle);
        do m.rotary[1].direction = direction_across(m.rotary[0].direction);
        while (m.rotary[1].direction.cross(m.spindle).norm() < std::sin(0.3));
        m.rotary[0].letter = 'A';
        m.rotary[1].letter = 'C';
        for (RotaryAxis& axis : m.rotary) {
            axis.point = vector(200);
            axis.sign = uniform(-1, 1) < 0 ? -1.0 : 1.0;
            axis.limits = {-100 * kPi, 100 * kPi, 1.0, 1.0, 0.0};
        }
        do
            for (LinearAxis& axis : m.linear) axis.direction = direction();
        while (std::abs(m.linear[0].direction.dot(m.linear[1].direction.cross(m.linear[2].direction))) < 0.3);
        for (int i = 0; i < 3; ++i) {
            m.linear[i].letter = "XYZ"[i];
            m.linear[i].limits = {-1e5, 1e5, 100.0, 1000.0, 0.0};
        }
        m.rapid = 300;
        return m;
    }

private:
    std::mt19937_64 random_;
};

}  // namespace trunnion
