#include <algorithm>

#include "check/engine.hpp"
#include "check/piece_bound.hpp"

namespace trunnion {

namespace {

constexpr double kFarGap = 0.05;  // of the distance to the limit that decides
constexpr int kMaxLevel = 48;     // halvings of a side: down to its rounding

/// Branch and bound over the tree, then over cells of the exact surface.
class Search {
public:
    Search(CellStore& cells, const Profile& profile, const ToolFrame& frame, double gap, double cap, double limit)
        : cells_(cells),
          index_(cells.index()),
          profile_(profile),
          frame_(frame),
          gap_(gap),
          limit_(limit),
          upper_(cap),
          lower_(std::numeric_limits<double>::infinity()) {}

    void offer(double value, const Vec3& world, std::uint32_t triangle) {
        if (value < upper_) {
            upper_ = value;
            point_ = world;
            triangle_ = triangle;
            found_ = true;
        }
    }

    void run() {
        struct Entry {
            std::uint32_t node;
            double bound;
        };
        std::array<Entry, CheckScene::Index::kDeepest> stack;
        std::size_t depth = 0;
        const auto bound = [&](std::uint32_t n) {
            return box_bound(profile_, frame_, index_.nodes[n].centre, index_.nodes[n].half);
        };
        stack[depth++] = {0, bound(0)};
        while (depth > 0) {
            const Entry entry = stack[--depth];
            if (done(entry.bound)) continue;
            const CheckScene::Index::Node& node = index_.nodes[entry.node];
            if (node.count > 0) {
                for (std::uint32_t i = node.first; i < node.first + node.count; ++i) triangle(i);
                continue;
            }
            const double a = bound(node.first), b = bound(node.first + 1);
            // The nearer child last, so that it comes first.
            const bool a_first = a <= b;
            stack[depth++] = a_first ? Entry{node.first + 1, b} : Entry{node.first, a};
            stack[depth++] = a_first ? Entry{node.first, a} : Entry{node.first + 1, b};
        }
    }

    void triangle(std::uint32_t slot) {
        const CheckScene::Index::Triangle& t = index_.triangles[slot];
        std::array<Vec3, 3> X;
        std::array<Sample, 3> s;
        for (std::size_t k = 0; k < 3; ++k) {
            X[k] = frame_.point(t.corner[k]);
            s[k] = sample(profile_, X[k]);
            offer(s[k].f + t.deviation, t.corner[k], slot);
        }
        const TangentRows rows = tangent_rows(X, s);
        if (done(corner_bound(rows) - t.deviation)) return;
        if (profile_.convex_in_space()) {
            const TriangleMinimum m = triangle_minimum(profile_, X, s, 0.25 * wanted_gap(), upper_ + t.deviation);
            offer(m.value + t.deviation, frame_.world(m.X), slot);
            if (done(m.lower - t.deviation)) return;
        }
        stack_.clear();
        stack_.push_back(cells_.root(slot));
        while (!stack_.empty()) {
            const std::uint32_t id = stack_.back();
            stack_.pop_back();
            refine(id);
        }
    }

    PieceDistance result(double cap) const {
        PieceDistance d;
        d.upper = std::min(upper_, cap);
        d.lower = std::min(lower_, d.upper);
        d.triangle = triangle_;
        if (found_) d.place.point = point_;
        if (triangle_ != PieceDistance::kNoTriangle) {
            d.place.body = index_.triangles[triangle_].body;
            d.place.face = static_cast<int>(index_.triangles[triangle_].face);
        }
        return d;
    }

private:
    /// fmax: without a limit the second term is NaN.
    double wanted_gap() const { return std::fmax(gap_, kFarGap * std::abs(upper_ - limit_)); }

    /// True if nothing behind this bound can change the answer; remembers the bound.
    bool done(double bound) {
        if (bound < upper_ - wanted_gap()) return false;
        lower_ = std::min(lower_, bound);
        return true;
    }

    void refine(std::uint32_t id) {
        const Cell& cell = cells_[id];
        std::array<Vec3, 3> X;
        std::array<Sample, 3> s;
        for (std::size_t k = 0; k < 3; ++k) {
            X[k] = frame_.point(cell.corner[k]);
            s[k] = sample(profile_, X[k]);
            offer(s[k].f, cell.corner[k], cell.triangle);
        }
        const TangentRows rows = tangent_rows(X, s);
        double bound = corner_bound(rows) - cell.r;
        if (done(bound)) return;
        if (profile_.convex_in_space()) {
            const TriangleMinimum m = triangle_minimum(profile_, X, s, 0.25 * wanted_gap(), upper_ + cell.r);
            // Some surface point lies within r of the flat minimum.
            offer(m.value + cell.r, frame_.world(m.X), cell.triangle);
            bound = std::max(bound, m.lower - cell.r);
            if (done(bound)) return;
        }
        bound = std::max(bound, mixed_bound(rows) - cell.r);
        if (done(bound)) return;
        if (cell.level >= kMaxLevel) {
            lower_ = std::min(lower_, bound);  // honest: the bound reached
            return;
        }
        const std::uint32_t first = cells_.children(id);
        for (std::uint32_t k = 0; k < 4; ++k) stack_.push_back(first + k);
    }

    CellStore& cells_;
    const CheckScene::Index& index_;
    const Profile& profile_;
    const ToolFrame frame_;
    double gap_, limit_, upper_, lower_;
    Vec3 point_ = Vec3::Zero();
    std::uint32_t triangle_ = PieceDistance::kNoTriangle;
    bool found_ = false;
    std::vector<std::uint32_t> stack_;
};

}  // namespace

PieceDistance piece_distance(CellStore& cells, const Cutter& cutter, std::size_t piece, const Vec3& tip, const Vec3& axis,
                             double gap, double cap, double limit, const DistanceHint& hint) {
    TRUNNION_REQUIRE(piece < cutter.pieces().size());
    cells.trim();
    const Profile& profile = cutter.pieces()[piece].profile;
    const ToolFrame frame = ToolFrame::at(tip, axis);
    Search search(cells, profile, frame, gap, cap, limit);
    if (hint.point) search.offer(sample(profile, frame.point(*hint.point)).f, *hint.point, PieceDistance::kNoTriangle);
    if (hint.triangle < cells.index().triangles.size()) search.triangle(hint.triangle);
    search.run();
    PieceDistance d = search.result(cap);
    d.place.tool_piece = cutter.pieces()[piece].name;
    return d;
}

PieceDistance piece_distance(const CheckScene& scene, const Cutter& cutter, std::size_t piece, const Vec3& tip, const Vec3& axis,
                             double gap, double cap, const DistanceHint& hint) {
    CellStore cells(scene.index());
    return piece_distance(cells, cutter, piece, tip, axis, gap, cap, std::numeric_limits<double>::quiet_NaN(), hint);
}

}  // namespace trunnion
