// Seeds: both rays over whole tiles of samples at once (private).
#pragma once

#include "pose/multipoint_impl.hpp"

namespace trunnion::detail {

using Block = std::array<double, Tile::kPadded>;

/// Heights (section 3) of a tile's samples; minus infinity where the ray misses.
void scan_heights(const ToolShape& tool, const Tile& tile, const Vec3& o, const Vec3& ex, const Vec3& ey, const Vec3& ez,
                  Block& heights);

/// Cosines of the turn until contact, for turns in [0, pi); minus infinity where there is none. Samples within `near` of P are
/// left out: there the value depends on the direction from P. `walls`: some of the tile may meet the tool above its torus.
void scan_turns(const ToolShape& tool, const Tile& tile, const Insert& frame, bool up, bool walls, double near, Block& cosines);

/// Calls found(index) for each inner sample above `threshold` that none of its eight neighbours exceeds.
template <class Found>
void local_maxima(const Block& values, double threshold, const Found& found) {
    constexpr int n = Tile::kSide;
    for (int i = 1; i < n - 1; ++i)
        for (int j = 1; j < n - 1; ++j) {
            const auto k = static_cast<std::size_t>(i * n + j);
            const double x = values[k];
            if (!(x > threshold)) continue;
            // Strictly above those before it, so that a plateau counts once.
            if (x > values[k - 1] && x >= values[k + 1] && x > values[k - n] && x >= values[k + n] && x > values[k - n - 1] &&
                x > values[k - n + 1] && x >= values[k + n - 1] && x >= values[k + n + 1])
                found(static_cast<int>(k));
        }
}

}  // namespace trunnion::detail
