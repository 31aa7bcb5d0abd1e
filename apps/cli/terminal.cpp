#include "terminal.hpp"

#include <csignal>
#include <cstdio>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

namespace trunnion::cli {

using Clock = std::chrono::steady_clock;

Progress::Progress(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1), start_(Clock::now()), last_(start_) {
    if (!spdlog::get("trunnion")) {
        auto logger = spdlog::stderr_logger_st("trunnion");
        logger->set_pattern("%v");
    }
}

Progress::~Progress() {
    clear();
}

Control Progress::control(const std::atomic<bool>& cancel) {
    Control c;
    c.cancel = &cancel;
    if (quiet_) return c;
    c.progress = [this](std::string_view stage, double fraction) { update(stage, fraction); };
    c.log = [this](std::string_view message) { say(message); };
    return c;
}

void Progress::update(std::string_view stage, double fraction) {
    const auto now = Clock::now();
    const bool fresh = stage != stage_;
    if (fresh) {
        clear();
        stage_ = stage;
        start_ = now;
        shown_ = -1.0;
    }
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const double since = std::chrono::duration<double>(now - last_).count();
    if (terminal_) {
        if (!fresh && since < 0.05 && fraction < 1.0) return;
        constexpr int kWidth = 30;
        const int full = static_cast<int>(fraction * kWidth);
        const double left = fraction > 0.02 ? seconds * (1.0 - fraction) / fraction : 0.0;
        std::fputs(fmt::format("\r\x1b[K  {:<24} [{}{}] {:3.0f} %{}", stage, std::string(static_cast<std::size_t>(full), '='),
                               std::string(static_cast<std::size_t>(kWidth - full), ' '), 100.0 * fraction,
                               left > 1.0 ? fmt::format("  {:.0f} s left", left) : "")
                       .c_str(),
                   stderr);
        drawn_ = true;
        if (fraction >= 1.0) clear();
    } else if (fresh || (since > 10.0 && fraction > shown_)) {
        std::fputs(fmt::format("{} {:.0f} %\n", stage, 100.0 * fraction).c_str(), stderr);
        shown_ = fraction;
    } else {
        return;
    }
    last_ = now;
    std::fflush(stderr);
}

void Progress::say(std::string_view message) {
    clear();
    spdlog::get("trunnion")->info(message);
}

void Progress::clear() {
    if (drawn_) std::fputs("\r\x1b[K", stderr);
    drawn_ = false;
}

namespace {
std::atomic<bool> interrupted{false};
void on_signal(int signal) {
    if (interrupted.exchange(true)) std::_Exit(128 + signal);
}
}  // namespace

const std::atomic<bool>& install_interrupt() {
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    return interrupted;
}

}  // namespace trunnion::cli
