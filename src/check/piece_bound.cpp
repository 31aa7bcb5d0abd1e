#include "check/piece_bound.hpp"

namespace trunnion {

namespace {

constexpr int kMaxSteps = 80;  // bisection alone would take 52

}  // namespace

// Bracketed by tangents: the two tangents' crossing is a lower bound and the next abscissa.
TriangleMinimum edge_minimum(const Profile& profile, const Vec3& A, const Vec3& B, const Sample& a, const Sample& b, double gap,
                             double enough) {
    const Vec3 e = B - A;
    double ta = 0.0, tb = 1.0, fa = a.f, fb = b.f, da = a.g.dot(e), db = b.g.dot(e);
    if (da >= 0.0) return {fa, fa, A};
    if (db <= 0.0) return {fb, fb, B};
    TriangleMinimum best{0.0, std::min(fa, fb), fa < fb ? A : B};
    for (int step = 0; step < kMaxSteps; ++step) {
        // Tangents fa + da (t - ta) and fb + db (t - tb) meet at the crossing; below it f cannot go.
        const double crossing = std::clamp((fb - fa + da * ta - db * tb) / (da - db), ta, tb);
        best.lower = std::min(best.value, std::max(fa + da * (crossing - ta), fb + db * (crossing - tb)));
        if (best.value - best.lower <= gap || best.lower >= enough) break;
        // Every third step halves the bracket: kinks of the profile cannot slow the search down.
        const double t = step % 3 == 2 ? 0.5 * (ta + tb) : crossing;
        if (!(t > ta && t < tb)) break;
        const Vec3 X = A + t * e;
        const Sample s = sample(profile, X);
        const double d = s.g.dot(e);
        if (s.f < best.value) best.value = s.f, best.X = X;
        if (d < 0.0)
            ta = t, fa = s.f, da = d;
        else if (d > 0.0)
            tb = t, fb = s.f, db = d;
        else {
            best.lower = s.f;
            break;
        }
    }
    return best;
}

double mixed_bound(const TangentRows& rows) {
    double best = corner_bound(rows);
    const auto offer = [&](const Vec3& mixture) { best = std::max(best, mixture.minCoeff()); };
    // The best mixture of k rows makes k columns equal: pairs of rows first, then all three.
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 &a = rows[i], &b = rows[(i + 1) % 3];
        for (Eigen::Index j = 0; j < 3; ++j) {
            const double da = a[j] - a[(j + 1) % 3], db = b[j] - b[(j + 1) % 3];
            if (da * db >= 0.0) continue;
            const double t = da / (da - db);
            offer((1.0 - t) * a + t * b);
        }
    }
    Vec3 first, second;
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Vec3& row = rows[static_cast<std::size_t>(i)];
        first[i] = row[0] - row[1];
        second[i] = row[0] - row[2];
    }
    Vec3 weight = first.cross(second);
    const double sum = weight.sum();
    if (sum == 0.0) return best;
    weight /= sum;
    if (weight.minCoeff() >= 0.0) offer(weight[0] * rows[0] + weight[1] * rows[1] + weight[2] * rows[2]);
    return best;
}

TriangleMinimum triangle_minimum(const Profile& profile, const std::array<Vec3, 3>& X, const std::array<Sample, 3>& s, double gap,
                                 double enough) {
    // For any direction d, f >= min over the corners of d.X - support(d). With d = +-N this is the least value on the whole
    // plane, attained at the support point moved onto the plane, unless the plane cuts deeper into the tool than the tool is
    // round there: `missed` is what is then missing.
    const Vec3 e1 = X[1] - X[0], e2 = X[2] - X[0];
    const Vec3 normal = e1.cross(e2);
    const double area2 = normal.norm(),
                 longest = std::sqrt(std::max({e1.squaredNorm(), e2.squaredNorm(), (e2 - e1).squaredNorm()}));
    constexpr double kSliver = 1e-8;  // relative height; below it the normal is off by ulp / kSliver and more
    double plane_bound = -std::numeric_limits<double>::infinity(), missed = 0.0;
    TriangleMinimum best;
    best.value = std::numeric_limits<double>::infinity();
    if (area2 > kSliver * longest * longest) {
        Vec3 foot = Vec3::Zero();
        for (const Vec3& d : {Vec3(normal / area2), Vec3(-normal / area2)}) {
            const double across = std::sqrt(d.x() * d.x() + d.y() * d.y());
            const Vec2 support = profile.support({across, d.z()});
            const double value = std::min({d.dot(X[0]), d.dot(X[1]), d.dot(X[2])}) - (support.x() * across + support.y() * d.z());
            if (value <= plane_bound) continue;
            plane_bound = value;
            const Vec3 on_tool = across > 0.0 ? Vec3(support.x() * d.x() / across, support.x() * d.y() / across, support.y())
                                              : Vec3(support.x(), 0.0, support.y());
            foot = on_tool + value * d - X[0];
        }
        if (plane_bound >= enough) return {plane_bound, plane_bound, X[0] + foot};
        const double u = foot.cross(e2).dot(normal) / (area2 * area2), v = e1.cross(foot).dot(normal) / (area2 * area2);
        const Vec3 in_plane = X[0] + u * e1 + v * e2;
        const double attained = sample(profile, in_plane).f;
        missed = std::max(0.0, attained - plane_bound);
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
            best = {plane_bound, attained, in_plane};
            if (missed <= gap) return best;
            missed = std::numeric_limits<double>::infinity();
        }
    } else {
        missed = area2 > 0.0 ? area2 / longest : 0.0;  // no point of a sliver is farther than its height from its edges
    }
    // From any point Y of the triangle the way to the point in the plane crosses an edge, where f <= max(f(Y), attained) by
    // convexity, and attained <= f(Y) + missed: the edges tell the minimum up to `missed`.
    double edges = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const TriangleMinimum edge = edge_minimum(profile, X[i], X[j], s[i], s[j], gap, std::min(enough, best.value));
        if (edge.value < best.value) best.value = edge.value, best.X = edge.X;
        edges = std::min(edges, edge.lower);
    }
    best.lower = std::min(best.value, std::max(edges - missed, plane_bound));
    return best;
}

}  // namespace trunnion
