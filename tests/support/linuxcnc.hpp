// Whether a headless LinuxCNC can run our programs here.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include <unistd.h>

namespace trunnion {

/// What is missing for `script` (the driver of a headless LinuxCNC), for the message of a skipped test; empty if nothing is.
inline std::optional<std::string> why_no_linuxcnc(const std::string& script) {
    if (!std::filesystem::exists(script)) return "the script that drives LinuxCNC is not here: " + script;
    if (!std::filesystem::exists("/usr/bin/milltask")) return "LinuxCNC is not installed (apt-get install linuxcnc-uspace)";
    if (::geteuid() != 0) return "LinuxCNC runs in namespaces of its own, which needs root";
    if (std::system("unshare --mount --ipc --pid --net --fork true 2>/dev/null") != 0)
        return "LinuxCNC runs in namespaces of its own, which this machine does not give (a bare chroot?)";
    return std::nullopt;
}

}  // namespace trunnion
