#include "trunnion/pose/pose_path.hpp"

#include <fmt/format.h>

namespace trunnion {

std::string_view name_of(PassKind kind) {
    switch (kind) {
        case PassKind::cut:
            return "cut";
        case PassKind::lead_in:
            return "lead-in";
        case PassKind::lead_out:
            return "lead-out";
        case PassKind::link:
            return "link";
    }
    return "?";
}

Result<PassKind> pass_kind(std::string_view name) {
    for (const PassKind kind : {PassKind::cut, PassKind::lead_in, PassKind::lead_out, PassKind::link})
        if (name_of(kind) == name) return kind;
    return fail(ErrorCode::invalid_input, fmt::format("unknown pass kind \"{}\"; known are cut, lead-in, lead-out, link", name));
}

}  // namespace trunnion
