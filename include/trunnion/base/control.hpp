// How a long run talks to its caller: progress, cancellation, messages.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "trunnion/base/result.hpp"

namespace trunnion {

/// Passed by reference through every long operation. All callbacks may be empty. `progress` may be called from any
/// thread, one call at a time; `cancelled` is polled at least every 50 ms of work.
struct Control {
    std::function<void(std::string_view stage, double fraction)> progress{};  ///< fraction in [0, 1]
    std::function<void(std::string_view message)> log{};                      ///< one line, no newline
    const std::atomic<bool>* cancel = nullptr;

    bool cancelled() const { return cancel && cancel->load(std::memory_order_relaxed); }
    void report(std::string_view stage, double fraction) const {
        if (progress) progress(stage, fraction);
    }
    void say(std::string_view message) const {
        if (log) log(message);
    }
};

/// The error every interrupted operation returns.
inline tl::unexpected<Error> fail_cancelled(std::string_view stage) {
    return fail(ErrorCode::cancelled, "interrupted during " + std::string(stage));
}

}  // namespace trunnion
