#include "trunnion/orientation/axis_set.hpp"

namespace trunnion {

namespace {

// Cube faces: the axis along which a face looks, and the two along which its angles run (right-handed).
struct CubeFace {
    int main, first, second;
    double sign;
};
constexpr std::array<CubeFace, 6> kFaces{
    {{0, 1, 2, 1.0}, {0, 2, 1, -1.0}, {1, 2, 0, 1.0}, {1, 0, 2, -1.0}, {2, 0, 1, 1.0}, {2, 1, 0, -1.0}}};

std::uint32_t cells_of(int level) {
    return 1u << (2 * level);
}

/// Every other bit, gathered.
std::uint32_t gather(std::uint32_t x) {
    x &= 0x55555555u;
    x = (x | (x >> 1)) & 0x33333333u;
    x = (x | (x >> 2)) & 0x0f0f0f0fu;
    x = (x | (x >> 4)) & 0x00ff00ffu;
    return (x | (x >> 8)) & 0x0000ffffu;
}
std::uint32_t spread(std::uint32_t x) {
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

/// The angle of a grid line: the face's 90 degrees in equal parts.
double grid_angle(double k, int level) {
    return (k / static_cast<double>(1u << level) - 0.5) * (0.5 * kPi);
}

Vec3 on_face(std::uint32_t face, double a, double b) {
    const CubeFace& f = kFaces[face];
    Vec3 v;
    v[f.main] = f.sign;
    v[f.first] = std::tan(a);
    v[f.second] = std::tan(b);
    return v.normalized();
}

struct Square {
    std::uint32_t face, i, j;
};
Square square_of(const AxisCell& cell) {
    const std::uint32_t count = cells_of(cell.level), code = cell.index % count;
    return {cell.index / count, gather(code), gather(code >> 1)};
}

std::uint32_t finest_cell(const Vec3& axis, int level) {
    std::uint32_t face = 0;
    double most = -1.0;
    for (std::uint32_t k = 0; k < 6; ++k) {
        const double along = kFaces[k].sign * axis[kFaces[k].main];
        if (along > most) most = along, face = k;
    }
    const CubeFace& f = kFaces[face];
    const auto n = static_cast<double>(1u << level);
    const auto line = [&](double x) {
        const double k = (std::atan(x / most) / (0.5 * kPi) + 0.5) * n;
        return static_cast<std::uint32_t>(std::clamp(std::floor(k), 0.0, n - 1.0));
    };
    return face * cells_of(level) + (spread(line(axis[f.first])) | (spread(line(axis[f.second])) << 1));
}

/// Solid angle between the face's middle and the corner (a, b) of a gnomonic rectangle.
double corner_area(double a, double b) {
    const double x = std::tan(a), y = std::tan(b);
    return std::atan2(x * y, std::sqrt(1.0 + x * x + y * y));
}
double area_of(const AxisCell& cell) {
    const Square s = square_of(cell);
    const double a0 = grid_angle(s.i, cell.level), a1 = grid_angle(s.i + 1.0, cell.level);
    const double b0 = grid_angle(s.j, cell.level), b1 = grid_angle(s.j + 1.0, cell.level);
    return corner_area(a1, b1) - corner_area(a0, b1) - corner_area(a1, b0) + corner_area(a0, b0);
}

/// The point of a cell nearest to a unit vector: the vector itself, or a point of one of its four sides.
Vec3 nearest_in(const AxisCell& cell, const Vec3& axis) {
    const std::array<Vec3, 4> corner = cell.corners();
    bool within = true;
    Vec3 best = corner[0];
    double most = -2.0;
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec3 &a = corner[k], &b = corner[(k + 1) % 4];
        const Vec3 normal = a.cross(b);  // points into the cell
        const double height = normal.dot(axis);
        if (height < 0.0) within = false;
        // The foot on the great circle, where it falls between the ends.
        const Vec3 foot = axis - (height / normal.squaredNorm()) * normal;
        const Vec3 candidate = foot.dot(normal.cross(a)) > 0.0 && foot.dot(b.cross(normal)) > 0.0 ? Vec3(foot.normalized())
                               : axis.dot(a) > axis.dot(b)                                        ? a
                                                                                                  : b;
        const double closeness = candidate.dot(axis);
        if (closeness > most) most = closeness, best = candidate;
    }
    return within ? axis : best;
}

void append(std::vector<AxisSet::Run>& runs, std::uint32_t first, std::uint32_t last) {
    if (!runs.empty() && runs.back().last == first)
        runs.back().last = last;
    else
        runs.push_back({first, last});
}

struct FinestRange {
    std::uint32_t first, last;
};
FinestRange range_of(const AxisCell& cell, int level) {
    const int shift = 2 * (level - cell.level);
    return {cell.index << shift, (cell.index + 1) << shift};
}

}  // namespace

std::array<Vec3, 4> AxisCell::corners() const {
    const Square s = square_of(*this);
    const double a0 = grid_angle(s.i, level), a1 = grid_angle(s.i + 1.0, level);
    const double b0 = grid_angle(s.j, level), b1 = grid_angle(s.j + 1.0, level);
    // Counter-clockwise seen from outside: a mirrored face runs the other way round.
    const bool mirrored = kFaces[s.face].sign * ((kFaces[s.face].first + 1) % 3 == kFaces[s.face].second ? 1.0 : -1.0) < 0.0;
    std::array<Vec3, 4> c{on_face(s.face, a0, b0), on_face(s.face, a1, b0), on_face(s.face, a1, b1), on_face(s.face, a0, b1)};
    if (mirrored) std::swap(c[1], c[3]);
    return c;
}

Vec3 AxisCell::centre() const {
    const Square s = square_of(*this);
    return on_face(s.face, grid_angle(s.i + 0.5, level), grid_angle(s.j + 0.5, level));
}

double AxisCell::radius() const {
    const Vec3 middle = centre();
    double least = 1.0;
    for (const Vec3& corner : corners()) least = std::min(least, middle.dot(corner));
    constexpr double kRounding = 1e-12;  // of the arc cosine
    return std::acos(least) + kRounding;
}

int AxisSet::level_for(double width) {
    TRUNNION_REQUIRE(width > 0.0);
    int level = 0;
    while (level < kMostLevel && std::sqrt(2.0) * 0.5 * kPi / static_cast<double>(1u << level) > width) ++level;
    return level;
}

AxisSet AxisSet::none(int level) {
    return from_runs(level, {});
}
AxisSet AxisSet::all(int level) {
    return from_runs(level, {{0, 6 * cells_of(level)}});
}
AxisSet AxisSet::from_runs(int level, std::vector<Run> runs) {
    TRUNNION_REQUIRE(level >= 0 && level <= kMostLevel);
    return AxisSet(level, std::move(runs));
}

AxisSet AxisSet::build(int level, const std::function<Coverage(const AxisCell&)>& classify) {
    std::vector<Run> runs;
    const auto descend = [&](const auto& self, const AxisCell& cell) -> void {
        const Coverage c = classify(cell);
        if (c == Coverage::outside) return;
        if (c == Coverage::inside) {
            const FinestRange r = range_of(cell, level);
            return append(runs, r.first, r.last);
        }
        if (cell.level == level) return;
        for (std::uint32_t k = 0; k < 4; ++k) self(self, cell.child(k));
    };
    for (std::uint32_t face = 0; face < 6; ++face) descend(descend, AxisCell{0, face});
    return from_runs(level, std::move(runs));
}

AxisSet AxisSet::cone(int level, const Vec3& axis, double half_angle) {
    return build(level, [&](const AxisCell& cell) {
        const double distance = angle_between(axis, cell.centre()), radius = cell.radius();
        if (distance + radius <= half_angle) return Coverage::inside;
        return distance - radius > half_angle ? Coverage::outside : Coverage::mixed;
    });
}

bool AxisSet::contains(const Vec3& axis) const {
    const std::uint32_t cell = finest_cell(axis, level_);
    const auto after =
        std::upper_bound(runs_.begin(), runs_.end(), cell, [](std::uint32_t c, const Run& r) { return c < r.first; });
    return after != runs_.begin() && cell < std::prev(after)->last;
}

Coverage AxisSet::coverage(const AxisCell& cell) const {
    const FinestRange r = range_of(cell, level_);
    const auto run =
        std::upper_bound(runs_.begin(), runs_.end(), r.first, [](std::uint32_t c, const Run& x) { return c < x.last; });
    if (run == runs_.end() || run->first >= r.last) return Coverage::outside;
    return run->first <= r.first && run->last >= r.last ? Coverage::inside : Coverage::mixed;
}

/// Calls visit(cell, coverage) from the six faces down; it says whether to go on into a mixed cell.
template <class Visit>
void AxisSet::visit(const Visit& visit) const {
    const auto descend = [&](const auto& self, const AxisCell& cell) -> void {
        const Coverage c = coverage(cell);
        if (!visit(cell, c) || c != Coverage::mixed) return;
        for (std::uint32_t k = 0; k < 4; ++k) self(self, cell.child(k));
    };
    for (std::uint32_t face = 0; face < 6; ++face) descend(descend, AxisCell{0, face});
}

double AxisSet::area() const {
    double sum = 0.0;
    visit([&](const AxisCell& cell, Coverage c) {
        if (c == Coverage::inside) sum += area_of(cell);
        return true;
    });
    return sum;
}

AxisSet AxisSet::intersect(const AxisSet& other) const {
    TRUNNION_REQUIRE(level_ == other.level_);
    std::vector<Run> runs;
    for (std::size_t i = 0, j = 0; i < runs_.size() && j < other.runs_.size();) {
        const Run &a = runs_[i], &b = other.runs_[j];
        const std::uint32_t first = std::max(a.first, b.first), last = std::min(a.last, b.last);
        if (first < last) append(runs, first, last);
        a.last < b.last ? ++i : ++j;
    }
    return AxisSet(level_, std::move(runs));
}

AxisSet AxisSet::complement() const {
    std::vector<Run> runs;
    std::uint32_t from = 0;
    for (const Run& run : runs_) {
        if (run.first > from) append(runs, from, run.first);
        from = run.last;
    }
    if (from < 6 * cells_of(level_)) append(runs, from, 6 * cells_of(level_));
    return AxisSet(level_, std::move(runs));
}

AxisSet AxisSet::unite(const AxisSet& other) const {
    return complement().intersect(other.complement()).complement();
}

AxisSet AxisSet::shrink(double angle) const {
    TRUNNION_REQUIRE(angle >= 0.0);
    return build(level_, [&](const AxisCell& cell) {
        if (coverage(cell) == Coverage::outside) return Coverage::outside;
        const double depth = distance_to_boundary(cell.centre()), radius = cell.radius();
        if (depth - radius >= angle) return Coverage::inside;
        return depth + radius < angle && contains(cell.centre()) ? Coverage::outside : Coverage::mixed;
    });
}

double AxisSet::distance_to_boundary(const Vec3& axis) const {
    if (!contains(axis)) return 0.0;
    double best = kPi;
    visit([&](const AxisCell& cell, Coverage c) {
        if (c == Coverage::inside) return false;
        if (angle_between(axis, cell.centre()) - cell.radius() >= best) return false;
        if (c == Coverage::outside) best = std::min(best, angle_between(axis, nearest_in(cell, axis)));
        return true;
    });
    return best;
}

std::optional<Vec3> AxisSet::project(const Vec3& axis) const {
    if (contains(axis)) return axis;
    double best = std::numeric_limits<double>::infinity();
    std::optional<Vec3> nearest;
    visit([&](const AxisCell& cell, Coverage c) {
        if (c == Coverage::outside) return false;
        const Vec3 middle = cell.centre();
        if (angle_between(axis, middle) - cell.radius() >= best) return false;
        if (c == Coverage::inside) {
            // A border belongs to one of its two cells only: step inwards until this one owns the point.
            Vec3 p = nearest_in(cell, axis);
            for (double step = 1e-12; step < 1.0 && !contains(p); step *= 4.0) p = (p + step * (middle - p)).normalized();
            if (!contains(p)) p = middle;
            const double distance = angle_between(axis, p);
            if (distance < best) best = distance, nearest = p;
        }
        return true;
    });
    return nearest;
}

std::optional<AxisSet::Cone> AxisSet::largest_cone() const {
    if (runs_.empty()) return std::nullopt;
    Cone best;
    best.half_angle = -1.0;
    // The depth changes by no more than the axis does: a cell cannot beat its centre by more than its radius.
    const auto descend = [&](const auto& self, const AxisCell& cell) -> void {
        if (coverage(cell) == Coverage::outside) return;
        const Vec3 middle = cell.centre();
        const double depth = distance_to_boundary(middle), radius = cell.radius();
        if (depth > best.half_angle && contains(middle)) best = {middle, depth};
        // Where the centre lies outside, its depth is not below zero but unknown: radius bounds it all the same.
        if (cell.level == level_ || depth + radius <= best.half_angle) return;
        for (std::uint32_t k = 0; k < 4; ++k) self(self, cell.child(k));
    };
    for (std::uint32_t face = 0; face < 6; ++face) descend(descend, AxisCell{0, face});
    return best;
}

}  // namespace trunnion
