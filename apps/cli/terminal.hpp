// Progress and messages on the terminal.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

#include "trunnion/base/control.hpp"

namespace trunnion::cli {

/// Progress on stderr: a bar that redraws itself on a terminal, a line per stage and per 10 seconds elsewhere.
class Progress {
public:
    explicit Progress(bool quiet);
    ~Progress();
    /// For the library; refers to this object.
    Control control(const std::atomic<bool>& cancel);

private:
    void update(std::string_view stage, double fraction);
    void say(std::string_view message);
    void clear();

    bool quiet_, terminal_, drawn_ = false;
    std::string stage_;
    double shown_ = -1.0;
    std::chrono::steady_clock::time_point start_, last_;
};

/// Set by the first SIGINT or SIGTERM; the second one ends the program at once.
const std::atomic<bool>& install_interrupt();

}  // namespace trunnion::cli
