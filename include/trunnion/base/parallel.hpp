// The one parallel loop. Threads (oneTBB) appear nowhere else.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "trunnion/base/control.hpp"

namespace trunnion {

/// Calls work(begin, end) over [0, count) in chunks of `grain`. The chunks are the same for any number of threads, and
/// each must write only to its own slots: results are then the same bits for any number of threads.
/// Error: cancelled, with no chunk started after the request. Exceptions of `work` pass through.
Result<void> parallel_for(std::size_t count, std::size_t grain, const Control& control, std::string_view stage,
                          const std::function<void(std::size_t begin, std::size_t end)>& work);

/// Number of threads used by parallel_for from now on; 0 = all cores.
void set_threads(unsigned count);
unsigned threads();

}  // namespace trunnion
