// Whole files in, whole files out.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"

namespace trunnion {

/// Error: not_found, io (a folder, no permission).
Result<std::string> read_file(const std::filesystem::path& path);

/// Either the whole new content is there afterwards or the old file is untouched, also when the process is killed or
/// the disc fills. Where the file system allows it (O_TMPFILE) a killed process leaves no trace at all.
/// Error: io, with the system's reason.
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view content);

struct FileToWrite {
    std::filesystem::path path;
    std::string_view content;
};
/// The same for several files: all contents are on the disc before the first name is changed, so a full disc or a kill while
/// writing leaves every old file as it was. Then `outdated` files are removed. Names change in the order given. Error: io.
Result<void> write_files_atomically(const std::vector<FileToWrite>& files,
                                    const std::vector<std::filesystem::path>& outdated = {});

/// Creates the folder and its parents, and proves that it can be written to. Error: io.
Result<void> prepare_folder(const std::filesystem::path& folder);

/// The entry of `known` that a misspelt `word` most likely means, or an empty view when nothing is close.
std::string_view nearest_word(std::string_view word, const std::vector<std::string_view>& known);

}  // namespace trunnion
