#include "trunnion/base/file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <numeric>
#include <random>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

namespace trunnion {

namespace fs = std::filesystem;

namespace {

std::string reason(int error) {
    return std::strerror(error);
}

/// A file descriptor that closes itself.
struct Descriptor {
    int fd = -1;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

int write_all(int fd, std::string_view content) {
    while (!content.empty()) {
        const ssize_t written = ::write(fd, content.data(), content.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        content.remove_prefix(static_cast<std::size_t>(written));
    }
    return ::fsync(fd) == 0 ? 0 : errno;
}

std::string temporary_name(const fs::path& path) {
    static thread_local std::mt19937_64 generator{std::random_device{}()};
    return (path.parent_path() / fmt::format(".{}.{:016x}.tmp", path.filename().string(), generator())).string();
}

}  // namespace

Result<std::string> read_file(const fs::path& path) {
    std::error_code code;
    if (!fs::exists(path, code)) return fail(ErrorCode::not_found, fmt::format("{}: no such file", path.string()));
    if (fs::is_directory(path, code)) return fail(ErrorCode::io, fmt::format("{}: is a folder, not a file", path.string()));
    std::ifstream in(path, std::ios::binary);
    if (!in) return fail(ErrorCode::io, fmt::format("{}: cannot be opened ({})", path.string(), reason(errno)));
    // In blocks: sizes of pipes and /proc files are not known beforehand.
    std::string content;
    for (std::size_t block = 1 << 16; in; block = std::max(block, content.size())) {
        const std::size_t before = content.size();
        content.resize(before + block);
        in.read(content.data() + before, static_cast<std::streamsize>(block));
        content.resize(before + static_cast<std::size_t>(in.gcount()));
    }
    if (in.bad()) return fail(ErrorCode::io, fmt::format("{}: cannot be read ({})", path.string(), reason(errno)));
    return content;
}

namespace {

/// Content on the disc without its final name. Where the file system allows it, without any name: if we are killed the
/// system takes it away.
class Staged {
public:
    Staged() = default;
    Staged(const Staged&) = delete;
    Staged& operator=(const Staged&) = delete;
    ~Staged() {
        if (named_) ::unlink(temporary_.c_str());
    }

    /// 0 or errno.
    int write(const fs::path& path, std::string_view content) {
        const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
        temporary_ = temporary_name(path);
        file_.fd = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
        if (file_.fd < 0) {
            if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) return errno;
            file_.fd = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
            if (file_.fd < 0) return errno;
            named_ = true;
        }
        return write_all(file_.fd, content);
    }

    /// Gives it its final name, replacing what is there. 0 or errno.
    int publish(const fs::path& path) {
        if (!named_) {
            const std::string self = fmt::format("/proc/self/fd/{}", file_.fd);
            if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary_.c_str(), AT_SYMLINK_FOLLOW) != 0) return errno;
            named_ = true;
        }
        if (::rename(temporary_.c_str(), path.c_str()) != 0) return errno;
        named_ = false;
        return 0;
    }

private:
    Descriptor file_;
    std::string temporary_;
    bool named_ = false;
};

}  // namespace

Result<void> write_files_atomically(const std::vector<FileToWrite>& files, const std::vector<fs::path>& outdated) {
    const auto failed = [](const fs::path& path, int error) {
        return fail(ErrorCode::io, fmt::format("{}: cannot be written ({})", path.string(), reason(error)));
    };
    std::vector<Staged> staged(files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (fs::is_directory(files[i].path)) return failed(files[i].path, EISDIR);
        if (const int error = staged[i].write(files[i].path, files[i].content)) return failed(files[i].path, error);
    }
    for (const fs::path& path : outdated) {
        std::error_code code;
        fs::remove(path, code);
        if (code)
            return fail(ErrorCode::io, fmt::format("{}: is outdated and cannot be removed ({})", path.string(), code.message()));
    }
    for (std::size_t i = 0; i < files.size(); ++i)
        if (const int error = staged[i].publish(files[i].path)) return failed(files[i].path, error);
    return {};
}

Result<void> write_file_atomically(const fs::path& path, std::string_view content) {
    return write_files_atomically({{path, content}});
}

Result<void> prepare_folder(const fs::path& folder) {
    std::error_code code;
    fs::create_directories(folder, code);
    if (code) return fail(ErrorCode::io, fmt::format("{}: cannot be created ({})", folder.string(), code.message()));
    if (!fs::is_directory(folder, code)) return fail(ErrorCode::io, fmt::format("{}: is not a folder", folder.string()));
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        return fail(ErrorCode::io, fmt::format("{}: cannot be written to ({})", folder.string(), reason(errno)));
    return {};
}

std::string_view nearest_word(std::string_view word, const std::vector<std::string_view>& known) {
    // Levenshtein distance; a word more than a third (and at least two letters) away helps nobody.
    const auto distance = [](std::string_view a, std::string_view b) {
        std::vector<std::size_t> row(b.size() + 1);
        std::iota(row.begin(), row.end(), std::size_t{0});
        for (std::size_t i = 1; i <= a.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i;
            for (std::size_t j = 1; j <= b.size(); ++j) {
                const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
                diagonal = row[j];
                row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
            }
        }
        return row.back();
    };
    std::string_view best;
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string_view candidate : known) {
        // A prefix is what people type when they forget the unit: "lead" for "lead_deg".
        const bool prefix = word.size() >= 3 && (candidate.starts_with(word) || word.starts_with(candidate));
        const std::size_t d = prefix ? 1 : distance(word, candidate);
        if (d < least) {
            least = d;
            best = candidate;
        }
    }
    return best;
}

}  // namespace trunnion
