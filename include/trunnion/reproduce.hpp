// The papers' tables beside ours: `trunnion reproduce NAME -o DIR`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/control.hpp"

namespace trunnion {

/// What a reproduction gives: a table for the terminal, and files (tables, figures) for the folder.
struct Reproduction {
    struct File {
        std::string name;  ///< without folder
        std::string content;
    };
    std::string table;
    std::vector<File> files;
    bool agrees = true;  ///< every figure lies within the tolerance that the table states
};

/// Names known to reproduce(), one per published method. A new one touches its source src/reproduce_<name>.cpp and the table in
/// src/reproduce.cpp.
std::vector<std::string_view> reproduction_names();

/// Error: not_found for an unknown name; whatever the reproduction meets; cancelled.
Result<Reproduction> reproduce(std::string_view name, const Control& control);

}  // namespace trunnion
