// The reproductions, one source each (private).
#pragma once

#include "trunnion/reproduce.hpp"

namespace trunnion {

/// Zou, Tam, Xu, Shi 2019: rotation-minimising orientation.
Result<Reproduction> reproduce_rmf(const Control& control);

}  // namespace trunnion
