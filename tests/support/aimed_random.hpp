// Random inputs for property tests: a fixed seed, replayed by TRUNNION_SEED, with generators that aim at trouble.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>

#include "trunnion/base/vec.hpp"

namespace trunnion {

class AimedRandom {
public:
    explicit AimedRandom(std::uint64_t seed) : seed_(override_of(seed)), generator_(seed_) {}

    std::uint64_t seed() const { return seed_; }
    double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(generator_); }
    double log_uniform(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
    int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(generator_); }
    bool coin(double probability = 0.5) { return uniform(0.0, 1.0) < probability; }
    Vec3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
    Vec3 direction() {
        while (true) {
            const Vec3 v = vector(1.0);
            const double length = v.norm();
            if (length > 1e-3 && length < 1.0) return v / length;
        }
    }
    /// A direction at `angle` from `from`, any way round.
    Vec3 leaning(const Vec3& from, double angle) {
        const Vec3 side = from.cross(std::abs(from.x()) < 0.7 ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY())).normalized();
        const double turn = uniform(0.0, 2.0 * kPi);
        const Vec3 across = std::cos(turn) * side + std::sin(turn) * from.cross(side);
        return (std::cos(angle) * from + std::sin(angle) * across).normalized();
    }

private:
    static std::uint64_t override_of(std::uint64_t seed) {
        const char* wanted = std::getenv("TRUNNION_SEED");
        return wanted ? std::strtoull(wanted, nullptr, 10) : seed;
    }
    std::uint64_t seed_;
    std::mt19937_64 generator_;
};

}  // namespace trunnion
