#include "trunnion/path/contact_path.hpp"

namespace trunnion {

void append_pass(ContactPath& path, const std::vector<Vec3>& cc, const std::vector<Vec3>& n, const std::vector<Vec2>& uv,
                 const std::vector<std::int32_t>& face, bool closed) {
    const std::size_t count = cc.size();
    if (count < 2) return;
    const std::size_t first = path.size();
    for (std::size_t i = 0; i < count; ++i) {
        const bool wraps = closed && count > 2;
        const Vec3& before = cc[i > 0 ? i - 1 : (wraps ? count - 2 : 0)];
        const Vec3& after = cc[i + 1 < count ? i + 1 : (wraps ? 1 : count - 1)];
        Vec3 f = after - before;
        f -= f.dot(n[i]) * n[i];
        const auto unit = UnitVector::from(f);
        if (!unit) continue;
        path.cc.push_back(cc[i]);
        path.n.push_back(n[i]);
        path.f.push_back(*unit);
        path.uv.push_back(uv[i]);
        path.face.push_back(face[i]);
        path.given.push_back(0);
    }
    const std::size_t added = path.size() - first;
    if (added < 2) {
        path.cc.resize(first);
        path.n.resize(first, Vec3::Zero());
        path.f.resize(first, Vec3::Zero());
        path.uv.resize(first, Vec2::Zero());
        path.face.resize(first);
        path.given.resize(first);
        return;
    }
    path.passes.push_back({first, added, closed});
}

void append_path(ContactPath& path, const ContactPath& more) {
    const std::size_t first = path.size();
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(path.cc, more.cc);
    append(path.n, more.n);
    append(path.f, more.f);
    append(path.uv, more.uv);
    append(path.face, more.face);
    append(path.given, more.given);
    for (ContactPass pass : more.passes) {
        pass.first += first;
        path.passes.push_back(pass);
    }
}

}  // namespace trunnion
