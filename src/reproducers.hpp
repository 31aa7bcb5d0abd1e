// The reproductions, one source each (private).
#pragma once

#include "trunnion/reproduce.hpp"

namespace trunnion {

/// Zou, Tam, Xu, Shi 2019: rotation-minimising orientation.
Result<Reproduction> reproduce_rmf(const Control& control);
/// Singh, Bedi, Mann: two-point positioning by vertical and circular rays.
Result<Reproduction> reproduce_vcrf(const Control& control);

}  // namespace trunnion
