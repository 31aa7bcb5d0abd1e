// How far a straight motion of the axes strays from the motion that was checked.
#pragma once

#include <array>

#include "machine/chain.hpp"

namespace trunnion::detail {

using RotaryWords = std::array<double, 2>;

/// Rotary axes that move straight from `words` to `next` while the checked axis goes on the great circle from `from` to
/// `to`, both at constant rate.
struct RotaryMotion {
    RotaryWords words, next;
    Vec3 from, to;
    double arc = 0.0;       ///< angle from -> to, or an upper bound of it
    double sin_tilt = 0.0;  ///< the greater of the two ends' sines of the angle to the outer axis
};

/// Upper bound of the angle between two unit vectors, from their distance c: 2 asin(c/2) <= c + (pi - 2)/8 c^3, with equality
/// at c = 0 and 2.
inline double arc_bound(const Vec3& a, const Vec3& b) {
    const double chord = (a - b).norm();
    return chord * (1.0 + (kPi - 2) / 8 * chord * chord);
}

/// Bound of the second derivative of (axis by the machine - axis on the great circle) over the unit interval.
/// With T = R(a, alpha) R(b, beta) s: |T''| <= alpha'^2 sin(a, T) + 2 |alpha' beta'| + beta'^2, and the great circle adds
/// arc^2. sin(a, T) grows from an end by |beta'| at most, since only beta changes the angle between a and T.
inline double bend_bound(const Chain& chain, const RotaryMotion& m) {
    const double da = std::abs(m.next[chain.outer()] - m.words[chain.outer()]);
    const double db = std::abs(m.next[chain.inner()] - m.words[chain.inner()]);
    const double sine = std::min(1.0, m.sin_tilt + db);
    return da * da * sine + 2 * da * db + db * db + m.arc * m.arc;
}

/// Upper bound of the angle between the two axes at equal times; exact enough to be at most `slack` whenever the true
/// one is clearly below. A result above `slack` was either attained or could not be excluded.
/// The difference f is 0 at both ends but for `end_error`; between two samples at distance h it exceeds the larger by at most
/// h^2/8 max|f''| (linear interpolation), which bend_bound() bounds.
double deviation_bound(const Chain& chain, const RotaryMotion& motion, double end_error, double slack);

/// Upper bound of the distance (mm) of the tip from the straight line between its ends when all five axes move
/// straight (no tool-centre-point control), at equal times.
double tip_deviation_bound(const Chain& chain, const JointPosition& from, const JointPosition& to, double tool_length);

}  // namespace trunnion::detail
