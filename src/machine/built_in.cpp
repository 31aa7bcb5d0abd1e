#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "machine/embedded.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion {

std::vector<std::string> built_in_machine_names() {
    std::vector<std::string> names;
    for (const auto& machine : detail::embedded_machines()) names.emplace_back(machine.name);
    std::sort(names.begin(), names.end());
    return names;
}

Result<Machine> built_in_machine(std::string_view name) {
    std::vector<std::string_view> names;
    for (const auto& machine : detail::embedded_machines()) {
        names.push_back(machine.name);
        if (machine.name != name) continue;
        auto read = machine_from_toml(machine.toml, "built-in");
        TRUNNION_REQUIRE(read.has_value());
        return read;
    }
    const std::string_view near = nearest_word(name, names);
    return fail(ErrorCode::not_found, near.empty()
                                          ? fmt::format("no built-in machine \"{}\"; there are {}", name, fmt::join(names, ", "))
                                          : fmt::format("no built-in machine \"{}\"; did you mean \"{}\"?", name, near));
}

}  // namespace trunnion
