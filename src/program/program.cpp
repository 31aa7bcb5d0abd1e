#include "trunnion/program/program.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "program/dialects.hpp"
#include "program/embedded.hpp"
#include "program/text.hpp"
#include "program/writer.hpp"
#include "trunnion/base/file.hpp"

namespace trunnion {

namespace {

/// What reading back may differ by: the contract of the header.
constexpr double kReadBackLinear = 1e-4;           // mm
constexpr double kReadBackRotary = radians(1e-4);  // rad
/// Axes of a plane program are the same to this (rad): a tenth of what may be lost in reading back.
constexpr double kSameAxis = radians(1e-5);

/// CLDATA statements have a slash after their word or are one of a few words; Heidenhain and Siemens programs hold words that
/// no other control has, Fanuc programs a program number or its codes of tool-centre-point control near the beginning.
std::string_view guess_dialect(std::string_view text) {
    constexpr std::size_t kBeginning = 4000;
    const std::string beginning = detail::upper(text.substr(0, kBeginning));
    std::string_view rest = beginning;
    bool bracketed = false;
    while (!rest.empty()) {
        const std::string_view line = detail::trimmed(detail::take_line(rest));
        if (line.find("BEGIN PGM") != std::string_view::npos) return "heidenhain";
        const std::string_view code = detail::trimmed(line.substr(0, line.find_first_of(";(")));
        for (const std::string_view word : {"TRAORI", "TRAFOOF", "ORIWKS", "ORIMKS", "CYCLE800", "SUPA"})
            if (code.find(word) != std::string_view::npos) return "siemens";
        for (const std::string_view word : {"G43.4", "G43.5", "G68.2"})
            if (code.find(word) != std::string_view::npos) return "fanuc";
        bracketed = bracketed || line == "%";
        if (bracketed && code.size() > 1 && code.front() == 'O' && code[1] >= '0' && code[1] <= '9') return "fanuc";
    }
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
    for (const auto& dialect : detail::embedded_dialects()) names.emplace_back(dialect.name);
    std::sort(names.begin(), names.end());
    return names;
}

Result<Dialect> find_dialect(std::string_view name_or_file) {
    if (name_or_file.ends_with(".toml")) return load_dialect(std::filesystem::path(std::string(name_or_file)));
    return built_in_dialect(name_or_file);
}

std::string file_ending(std::string_view dialect) {
    const auto known = find_dialect(dialect);
    return known ? known->ending : "txt";
}

Result<std::string> write_program(const MachinePath& path, const ProgramOptions& options) {
    const auto dialect = find_dialect(options.dialect);
    if (!dialect) return tl::unexpected(dialect.error());
    const bool axis_words = dialect->syntax != Syntax::apt;
    if (options.plane && dialect->plane_angles == Dialect::PlaneAngles::none)
        return fail(ErrorCode::invalid_input,
                    fmt::format("dialect {} has no tilted plane; leave plane out or choose another dialect", dialect->name));
    if (!options.plane && options.tcp && !path.machine().tcp && axis_words)
        return fail(
            ErrorCode::invalid_input,
            fmt::format("machine {} has no tool-centre-point control; set tcp = false for this program", path.machine().name));
    if (!options.plane && !options.tcp && !dialect->without_tcp && axis_words)
        return fail(
            ErrorCode::invalid_input,
            fmt::format("dialect {} is written under tool-centre-point control only; leave tcp = false out", dialect->name));
    if (path.poses().size() == 0) return fail(ErrorCode::invalid_input, "the path has no poses, there is nothing to write");
    if (!path.valid() && !options.allow_invalid) {
        const auto& why = path.why();
        const auto bad = [](const std::string& text) { return !text.empty(); };
        const auto first = std::find_if(why.begin(), why.end(), bad);
        return fail(ErrorCode::invalid_input,
                    fmt::format("{} of {} poses are not valid, no program is written; the first is pose {}: {}",
                                std::count_if(why.begin(), why.end(), bad), why.size(), first - why.begin(), *first));
    }
    const JointPosition& first = path.joints().front();
    for (std::size_t i = 0; i < path.poses().size(); ++i) {
        double size = path.poses().cl[i].cwiseAbs().maxCoeff();
        for (const double word : path.joints()[i]) size = std::max(size, std::abs(word));
        if (!(size < radians(detail::kGreatestWord)) || !path.poses().axis[i].allFinite())
            return fail(ErrorCode::invalid_input, fmt::format("pose {} is not a position that a program can hold", i));
        if (!options.plane) continue;
        const JointPosition& q = path.joints()[i];
        const double off = std::max(
            {angle_between(path.poses().axis[0], path.poses().axis[i]), std::abs(q[3] - first[3]), std::abs(q[4] - first[4])});
        if (off > kSameAxis)
            return fail(
                ErrorCode::invalid_input,
                fmt::format("a plane program needs one orientation for the whole path, but at pose {} the tool or a rotary "
                            "axis stands {:.4g} deg from pose 0",
                            i, degrees(off)));
    }
    return detail::write_in(*dialect, path, options);
}

Result<ProgramText> read_program(std::string_view text, std::string_view name, const Machine* machine, double tool_length) {
    const auto dialect = find_dialect(name.empty() ? guess_dialect(text) : name);
    if (!dialect) return tl::unexpected(dialect.error());
    const auto read = [&]() -> Result<ProgramText> {
        if (dialect->syntax == Syntax::apt) return detail::read_apt(text);
        if (!machine)
            return fail(ErrorCode::invalid_input,
                        fmt::format("a {} program holds axis words: name the machine it is meant for", dialect->name));
        switch (dialect->syntax) {
            case Syntax::fanuc:
                return detail::read_fanuc(text, *machine, tool_length);
            case Syntax::siemens:
                return detail::read_siemens(text, *machine, tool_length);
            case Syntax::heidenhain:
                return detail::read_heidenhain(text, *machine, tool_length);
            default:
                return detail::read_linuxcnc(text, *machine, tool_length);
        }
    };
    auto program = read();
    if (program) program->dialect = dialect->name;
    return program;
}

namespace {

/// Where the control has the tool half way between two blocks.
TipPose middle(const ProgramBlock& from, const ProgramBlock& to, Interpolation interpolation, const MachinePath& path) {
    const Vec3 tip = 0.5 * (from.tip.cl + to.tip.cl);
    if (interpolation == Interpolation::great_circle) return {tip, slerp(from.tip.axis, to.tip.axis, 0.5)};
    JointPosition joints;
    for (int j = 0; j < 5; ++j) joints[j] = 0.5 * (from.joints[j] + to.joints[j]);
    const TipPose pose = forward(path.machine(), joints, path.options().tool_length);
    return interpolation == Interpolation::all_axes ? pose : TipPose{tip, pose.axis};
}

}  // namespace

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
                if (program.tcp && j < 3) continue;  // follows from tip and rotary words, judged below
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

        if (i == 0 || !path.why()[i - 1].empty()) continue;
        const ProgramBlock& before = program.blocks[i - 1];
        if (program.interpolation != Interpolation::great_circle && !(before.has_joints && block.has_joints))
            return fail(ErrorCode::unreadable, fmt::format("line {}: a block without positions of the rotary axes", block.line));
        const TipPose half = middle(before, block, program.interpolation, path);
        const double off_line = (half.cl - 0.5 * (path.poses().cl[i - 1] + path.poses().cl[i])).norm();
        const double off_circle = angle_between(half.axis, slerp(path.poses().axis[i - 1], path.poses().axis[i], 0.5));
        worst.motion_tip = std::max(worst.motion_tip, off_line);
        worst.motion_axis = std::max(worst.motion_axis, off_circle);
        const double tip_slack = program.interpolation == Interpolation::all_axes ? path.options().tip_slack : 0.0;
        if (!(off_line <= tip_slack + kReadBackLinear)) return differs("the tip half way to this block", off_line, "mm");
        if (!(off_circle <= path.checked().axis_slack(i) + kReadBackRotary))
            return differs("the tool axis half way to this block", degrees(off_circle), "deg");
    }
    return worst;
}

}  // namespace trunnion
