#pragma once

namespace trunnion {

/// What the user allows. Always passed, never global. Arithmetic uncertainty is a different thing (an epsilon, computed).
struct Tolerance {
    double chord = 0.01;                  ///< mm, between the contact path and its chords
    double gouge = 0.001;                 ///< mm, depth below the designed surface that still counts as valid
    double scallop = 0.02;                ///< mm, material left between passes
    double angle = 0.017453292519943295;  ///< rad, greatest turn of the surface normal per step (default 1 deg)
};

}  // namespace trunnion
