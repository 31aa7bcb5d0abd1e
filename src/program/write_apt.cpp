#include <fmt/format.h>

#include "program/dialects.hpp"
#include "program/text.hpp"

namespace trunnion::detail {

namespace {
constexpr int kPositionDecimals = 9, kAxisDecimals = 10, kFeedDigits = 7;
constexpr std::size_t kCommentLength = 60;
}  // namespace

std::string write_apt(const MachinePath& path, const ProgramOptions& options) {
    std::string out;
    out.reserve(400 + path.poses().size() * 110);
    out += fmt::format("PARTNO/{}\n", options.title.empty() ? "PART" : comment_text(options.title, kCommentLength));
    out += fmt::format("$$ Trunnion {}, machine {}\n", TRUNNION_VERSION, comment_text(path.machine().name, kCommentLength));
    out += "UNITS/MM\nMULTAX/ON\n";
    if (options.tool_diameter > 0) out += fmt::format("CUTTER/{:.6f},{:.6f}\n", options.tool_diameter, options.tool_corner);
    out += fmt::format("LOADTL/{},LENGTH,{:.6f}\n", options.tool_number, path.options().tool_length);
    if (options.spindle_rpm > 0) out += fmt::format("SPINDL/{:.3f},RPM,CLW\n", options.spindle_rpm);

    const PosePath& poses = path.poses();
    Decimal feed{-1, 0};
    for (std::size_t k = 0; k < poses.passes.size(); ++k) {
        const Pass& pass = poses.passes[k];
        out += fmt::format("$$ pass {}: {}\n", k, name_of(pass.kind));
        for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
            if (pass.rapid) {
                out += "RAPID\n";
            } else if (path.feed()[i] > 0) {
                const Decimal now = rounded(path.feed()[i] * 60.0, kFeedDigits);
                if (now != feed) {
                    out += "FEDRAT/";
                    append(out, now);
                    out += ",MMPM\n";
                    feed = now;
                }
            }
            if (!path.why()[i].empty()) out += fmt::format("$$ INVALID: {}\n", comment_text(path.why()[i], kCommentLength * 3));
            out += "GOTO/";
            for (int j = 0; j < 3; ++j) {
                append(out, fixed(poses.cl[i][j], kPositionDecimals));
                out += ',';
            }
            for (int j = 0; j < 3; ++j) {
                append(out, fixed(poses.axis[i][j], kAxisDecimals));
                out += j < 2 ? ',' : '\n';
            }
        }
    }
    if (options.spindle_rpm > 0) out += "SPINDL/OFF\n";
    out += "END\nFINI\n";
    return out;
}

}  // namespace trunnion::detail
