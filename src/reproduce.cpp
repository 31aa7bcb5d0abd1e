#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reproducers.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion {

namespace {

struct Entry {
    std::string_view name;
    Result<Reproduction> (*run)(const Control&);
};

/// One line per published method.
constexpr Entry kTable[] = {
    {"rmf", reproduce_rmf},
};

}  // namespace

std::vector<std::string_view> reproduction_names() {
    std::vector<std::string_view> names;
    for (const Entry& entry : kTable) names.push_back(entry.name);
    return names;
}

Result<Reproduction> reproduce(std::string_view name, const Control& control) {
    for (const Entry& entry : kTable)
        if (entry.name == name) return entry.run(control);
    const std::vector<std::string_view> names = reproduction_names();
    const std::string_view near = nearest_word(name, names);
    return fail(ErrorCode::not_found,
                near.empty() ? fmt::format("no reproduction is called \"{}\"; known are {}", name, fmt::join(names, ", "))
                             : fmt::format("no reproduction is called \"{}\"; did you mean \"{}\"?", name, near));
}

}  // namespace trunnion
