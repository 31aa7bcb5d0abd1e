// Paths through the machine room for tests of programs.
#pragma once

#include <random>

#include "support/make_checked_path.hpp"
#include "trunnion/machine/machine_path.hpp"

namespace trunnion {

inline constexpr double kToolLength = 120.0;

/// A wandering path of n poses with a rapid link in the middle: tilt between 5 and 45 degrees, all azimuths, axes of full
/// precision.
inline PosePath wandering_poses(std::size_t n, unsigned seed) {
    std::mt19937_64 random(seed);
    const auto phase = [&] { return std::uniform_real_distribution<double>(0, 2 * kPi)(random); };
    const double a = phase(), b = phase(), c = phase(), d = phase();
    PosePath poses;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = 0.02 * static_cast<double>(i);
        poses.cl.emplace_back(60 * std::sin(t + a), 50 * std::sin(0.7 * t + b), 10 + 8 * std::sin(1.3 * t + c));
        const double tilt = radians(25 + 20 * std::sin(0.9 * t + d)), azimuth = 1.1 * t + a;
        poses.axis.emplace_back(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
    }
    poses.contact.assign(n, -1);
    const std::size_t half = n / 2, link = std::min<std::size_t>(10, n - half);
    // A straight piece of the link without a turn of the tool.
    for (std::size_t i = half + 1; i + 2 < half + link; ++i) poses.axis[i] = poses.axis[half];
    poses.passes = {{0, half, PassKind::cut, false},
                    {half, link, PassKind::link, true},
                    {half + link, n - half - link, PassKind::cut, false}};
    return poses;
}

inline MachinePath path_on(const Machine& machine, PosePath poses, bool tcp = true) {
    MotionOptions options;
    options.tool_length = kToolLength;
    options.tcp = tcp;
    auto path = move_machine(detail::CheckedPathMaker::unchecked_for_test(std::move(poses), radians(5)), machine, options, {});
    TRUNNION_REQUIRE(path.has_value());
    return *path;
}

}  // namespace trunnion
