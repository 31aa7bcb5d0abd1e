#include "trunnion/pose/place.hpp"

#include <fmt/format.h>

namespace trunnion {

Result<PosePath> place_cutter(const ContactPath& contacts, const std::vector<Vec3>& axes, const Cutter& cutter) {
    if (axes.size() != contacts.size())
        return fail(ErrorCode::invalid_input, fmt::format("{} contacts but {} axes", contacts.size(), axes.size()));
    PosePath path;
    path.cl.reserve(contacts.size());
    path.axis = axes;
    path.contact.reserve(contacts.size());
    for (std::size_t pass = 0; pass < contacts.passes.size(); ++pass) {
        const ContactPass& p = contacts.passes[pass];
        for (std::size_t i = p.first; i < p.first + p.count; ++i) {
            auto tip = tool_tip(cutter, contacts.cc[i], contacts.n[i], axes[i]);
            if (!tip)
                return tl::unexpected(std::move(tip.error()).in(fmt::format("contact {}", i)).in(fmt::format("pass {}", pass)));
            path.cl.push_back(*tip);
            path.contact.push_back(static_cast<std::int64_t>(i));
        }
        path.passes.push_back({p.first, p.count, PassKind::cut, false});
    }
    return path;
}

}  // namespace trunnion
