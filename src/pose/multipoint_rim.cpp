#include "pose/multipoint_rim.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::detail {

void Rims::add(const Field& field, std::uint32_t index, double spacing) {
    if (!field.trimmed()) return;
    const auto clamped = [&](const Vec2& p) {
        return Vec2(std::clamp(p.x(), field.u().lo, field.u().hi), std::clamp(p.y(), field.v().lo, field.v().hi));
    };
    for (const auto& loop : field.trim()->loops()) {
        const std::size_t first = segments.size();
        for (std::size_t k = 0; k < loop.size(); ++k) {
            const Vec2 a = loop[k], b = loop[(k + 1) % loop.size()];
            // A loop of the face runs through several blocks; each keeps what lies in it.
            const Vec2 middle = 0.5 * (a + b);
            if ((clamped(middle) - middle).squaredNorm() > 0.0 || a == b) continue;
            const Vec2 from = clamped(a), to = clamped(b);
            const double length = (field.at(to.x(), to.y()).S - field.at(from.x(), from.y()).S).norm();
            const int pieces = std::clamp(static_cast<int>(std::ceil(length / spacing)), 1, 4096);
            for (int i = 0; i < pieces; ++i) {
                RimSegment s;
                s.field = index;
                s.from = from + (to - from) * (static_cast<double>(i) / pieces);
                s.to = from + (to - from) * (static_cast<double>(i + 1) / pieces);
                s.start = field.at(s.from.x(), s.from.y()).S;
                segments.push_back(s);
            }
        }
        const std::size_t end = segments.size();
        for (std::size_t k = first; k < end; ++k) {
            segments[k].next = static_cast<std::uint32_t>(k + 1 < end ? k + 1 : first);
            segments[k].previous = static_cast<std::uint32_t>(k > first ? k - 1 : end - 1);
        }
    }
}

void Rims::build() {
    std::vector<Box3> boxes;
    for (const RimSegment& s : segments) {
        Box3 box;
        box.add(s.start);
        box.add(segments[s.next].start);
        boxes.push_back(box);
    }
    tree = BoxTree(boxes, 8);
}

}  // namespace trunnion::detail
