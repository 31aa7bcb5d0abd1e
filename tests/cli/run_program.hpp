// Runs the trunnion program as a user would.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

namespace cli_tests {

namespace fs = std::filesystem;

struct Finished {
    int exit = -1;
    std::string out, err;
};

inline std::string slurp(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A fresh folder that goes away with the object.
class Folder {
public:
    Folder() {
        std::string name = (fs::temp_directory_path() / "trunnion-test-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& path() const { return path_; }
    fs::path write(const std::string& name, const std::string& content) const {
        std::ofstream(path_ / name, std::ios::binary) << content;
        return path_ / name;
    }
    std::size_t entries() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

private:
    fs::path path_;
};

inline Finished run_trunnion(const std::string& arguments) {
    const Folder folder;
    const std::string command =
        std::string(TRUNNION_PROGRAM) + " " + arguments + " >" + (folder / "out").string() + " 2>" + (folder / "err").string();
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(folder / "out"), slurp(folder / "err")};
}

/// A job that plans in a fraction of a second: a shallow dome under a ball cutter.
inline std::string dome_job(const std::string& cutter = "shape = \"ball\"\ndiameter_mm = 8", const std::string& more = "") {
    return "[part]\nsurface = { kind = \"dome\", height_mm = 6, a_mm = 30, b_mm = 20 }\n[cutter]\n" + cutter +
           "\n[path]\npasses = 6\nmargin_mm = 1\n[orientation]\nmethod = \"sturz\"\nlead_deg = 10\n" + more;
}

}  // namespace cli_tests
