// The [path] keys of paths given point by point (private).
#pragma once

#include <filesystem>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "base/toml_reader.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {

/// Numbers of a CSV file: `columns` of them a row, separated by commas, semicolons or blanks; '#' starts a comment, and a first
/// row of words names the columns. Error: invalid_input or unreadable with file and line.
struct NumberTable {
    std::vector<std::string> names;  ///< of the columns; empty without a header
    std::vector<std::vector<double>> rows;
};
Result<NumberTable> read_number_table(const std::filesystem::path& file, std::size_t columns);

/// The pattern if it is one of those, else nothing. Files are read here: the resolved job holds the points.
std::optional<Pattern> read_given_path(TomlReader& r, std::string_view pattern, const std::filesystem::path& folder);

/// Its keys for the resolved job; null for other patterns.
nlohmann::ordered_json json_of_given_path(const Pattern& pattern);

}  // namespace trunnion
