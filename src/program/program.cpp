#include "trunnion/program/program.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "program/dialects.hpp"
#include "program/text.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion {

namespace {

struct Dialect {
    std::string_view name, ending;
    std::string (*write)(const MachinePath&, const ProgramOptions&);
};
constexpr Dialect kDialects[] = {
    {"apt", "cls", detail::write_apt},
    {"linuxcnc", "ngc", detail::write_linuxcnc},
};

/// What reading back may differ by: the contract of the header.
constexpr double kReadBackLinear = 1e-4;           // mm
constexpr double kReadBackRotary = radians(1e-4);  // rad

Result<const Dialect*> find_dialect(std::string_view name) {
    std::vector<std::string_view> names;
    for (const Dialect& dialect : kDialects) {
        if (dialect.name == name) return &dialect;
        names.push_back(dialect.name);
    }
    const std::string_view near = nearest_word(name, names);
    return fail(ErrorCode::invalid_input, near.empty()
                                              ? fmt::format("unknown dialect \"{}\"; there are {}", name, fmt::join(names, ", "))
                                              : fmt::format("unknown dialect \"{}\"; did you mean \"{}\"?", name, near));
}

/// CLDATA statements have a slash after their word or are one of a few words; RS-274 knows neither.
std::string_view guess_dialect(std::string_view text) {
    while (!text.empty()) {
        const std::string line = detail::upper(detail::trimmed(detail::take_line(text)));
        if (line.empty() || line.front() == '(' || line.front() == ';') continue;
        for (const std::string_view word :
             {"$$", "PARTNO", "UNITS", "GOTO", "TOOL PATH", "MULTAX", "CUTTER", "FEDRAT", "LOADTL", "PPRINT", "RAPID", "FINI"})
            if (line.starts_with(word)) return "apt";
        return "linuxcnc";
    }
    return "linuxcnc";
}

}  // namespace

std::vector<std::string> dialect_names() {
    std::vector<std::string> names;
    for (const Dialect& dialect : kDialects) names.emplace_back(dialect.name);
    return names;
}

std::string file_ending(std::string_view dialect) {
    for (const Dialect& known : kDialects)
        if (known.name == dialect) return std::string(known.ending);
    return "txt";
}

Result<std::string> write_program(const MachinePath& path, const ProgramOptions& options) {
    const auto dialect = find_dialect(options.dialect);
    if (!dialect) return tl::unexpected(dialect.error());
    if (options.tcp && !path.machine().tcp && options.dialect != "apt")
        return fail(
            ErrorCode::invalid_input,
            fmt::format("machine {} has no tool-centre-point control; set tcp = false for this program", path.machine().name));
    if (path.poses().size() == 0) return fail(ErrorCode::invalid_input, "the path has no poses, there is nothing to write");
    if (!path.valid() && !options.allow_invalid) {
        const auto& why = path.why();
        const auto bad = [](const std::string& text) { return !text.empty(); };
        const auto first = std::find_if(why.begin(), why.end(), bad);
        return fail(ErrorCode::invalid_input,
                    fmt::format("{} of {} poses are not valid, no program is written; the first is pose {}: {}",
                                std::count_if(why.begin(), why.end(), bad), why.size(), first - why.begin(), *first));
    }
    for (std::size_t i = 0; i < path.poses().size(); ++i) {
        double size = path.poses().cl[i].cwiseAbs().maxCoeff();
        for (const double word : path.joints()[i]) size = std::max(size, std::abs(word));
        if (!(size < radians(detail::kGreatestWord)) || !path.poses().axis[i].allFinite())
            return fail(ErrorCode::invalid_input, fmt::format("pose {} is not a position that a program can hold", i));
    }
    return (*dialect)->write(path, options);
}

Result<ProgramText> read_program(std::string_view text, std::string_view dialect, const Machine* machine, double tool_length) {
    const std::string_view name = dialect.empty() ? guess_dialect(text) : dialect;
    const auto known = find_dialect(name);
    if (!known) return tl::unexpected(known.error());
    if (name == "apt") return detail::read_apt(text);
    if (!machine)
        return fail(ErrorCode::invalid_input,
                    fmt::format("a {} program holds axis words: name the machine it is meant for", name));
    return detail::read_linuxcnc(text, *machine, tool_length);
}

Result<ReadBack> compare_with_path(const ProgramText& program, const MachinePath& path) {
    const std::size_t n = path.poses().size();
    if (program.blocks.size() != n)
        return fail(ErrorCode::unreadable,
                    fmt::format("the program has {} motion blocks but the path {} poses", program.blocks.size(), n));
    ReadBack worst;
    worst.blocks = n;
    for (std::size_t i = 0; i < n; ++i) {
        const ProgramBlock& block = program.blocks[i];
        const auto differs = [&](std::string_view what, double by, std::string_view unit) {
            return fail(ErrorCode::unreadable,
                        fmt::format("line {}: {} differs from pose {} of the path by {:.3g} {}", block.line, what, i, by, unit));
        };
        if (block.has_joints) {
            for (int j = 0; j < 5; ++j) {
                const double difference = std::abs(block.joints[j] - path.joints()[i][j]);
                double& largest = j < 3 ? worst.joints_linear : worst.joints_rotary;
                largest = std::max(largest, difference);
                if (!(difference <= (j < 3 ? kReadBackLinear : kReadBackRotary)))
                    return differs("an axis position", j < 3 ? difference : degrees(difference), j < 3 ? "mm" : "deg");
            }
            if (!path.why()[i].empty()) continue;
        }
        const double tip = (block.tip.cl - path.poses().cl[i]).norm();
        const double axis = angle_between(block.tip.axis, path.poses().axis[i]);
        worst.tip = std::max(worst.tip, tip);
        worst.axis = std::max(worst.axis, axis);
        if (!(tip <= kReadBackLinear)) return differs("the tool tip", tip, "mm");
        if (!(axis <= kReadBackRotary)) return differs("the tool axis", degrees(axis), "deg");
    }
    return worst;
}

}  // namespace trunnion
