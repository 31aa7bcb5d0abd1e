#include "trunnion/machine/singularity.hpp"

#include <algorithm>
#include <cmath>

#include "machine/chain.hpp"

namespace trunnion {

namespace {

/// Half the length of a detour, in cones.
constexpr double kReach = 4.0;
/// A dip during which the outer axis turns by less than this is no trouble.
constexpr double kHarmlessTurn = radians(20.0);
/// Between two axes of the path the great circle cuts the corner of the detour: nearer than this part of the cone another lean
/// follows, as long as all of them together stay below the most.
constexpr double kNearEnough = 0.99, kMostLean = 1.3;
/// Dips of one run that are gone round at most; each takes one away.
constexpr int kMostDips = 64;

/// The point of the great circle from a to b that is nearest to p, and where it is (0 at a, 1 at b).
double nearest_on_arc(const Vec3& a, const Vec3& b, const Vec3& p) {
    const double arc = angle_between(a, b);
    if (!(arc > 0)) return 0.0;
    const Vec3 across = (b - a.dot(b) * a).normalized();
    return std::clamp(std::atan2(p.dot(across), p.dot(a)) / arc, 0.0, 1.0);
}

class Run {
public:
    Run(std::span<Vec3> axes, const Vec3& pole, double cone) : axes_(axes), pole_(pole), cone_(cone) {}

    /// Goes round the closest dip that needs it. False when there is none left.
    bool go_round_one() {
        measure();
        std::size_t best = 0;
        double nearest = cone_ * kNearEnough, at = 0.0;
        for (std::size_t i = 0; i + 1 < axes_.size(); ++i) {
            const double t = nearest_on_arc(axes_[i], axes_[i + 1], pole_);
            const double distance = angle_between(slerp(axes_[i], axes_[i + 1], t), pole_);
            if (distance < nearest && turn_near(i) > kHarmlessTurn) nearest = distance, best = i, at = t;
        }
        if (nearest >= cone_ * kNearEnough) return false;
        const Vec3 closest = slerp(axes_[best], axes_[best + 1], at);
        // Away from the pole; exactly through it, to the left of the way.
        Vec3 away = closest - closest.dot(pole_) * pole_;
        const Vec3 way = axes_[best + 1] - axes_[best];
        constexpr double kThrough = 1e-9;
        if (away.norm() < kThrough) away = pole_.cross(way);
        if (!(away.norm() > 0)) return false;
        const Vec3 about = pole_.cross(away).normalized();
        const double lean = cone_ - nearest, centre = way_[best] + at * (way_[best + 1] - way_[best]);
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const double x = std::abs(way_[i] - centre) / (kReach * cone_);
            if (x >= 1.0) continue;
            const double c = std::cos(0.5 * kPi * x);
            axes_[i] = detail::turned(axes_[i], about, detail::CosSin::of(lean * c * c)).normalized();
        }
        return true;
    }

private:
    void measure() {
        way_.assign(axes_.size(), 0.0);
        azimuth_.assign(axes_.size(), 0.0);
        const Vec3 u = any_perpendicular(pole_), v = pole_.cross(u);
        double last = 0.0;
        for (std::size_t i = 0; i < axes_.size(); ++i) {
            const double angle = std::atan2(axes_[i].dot(v), axes_[i].dot(u));
            if (i > 0) {
                way_[i] = way_[i - 1] + angle_between(axes_[i - 1], axes_[i]);
                azimuth_[i] = azimuth_[i - 1] + std::abs(detail::principal(angle - last));
            }
            last = angle;
        }
    }
    /// How far the outer axis turns while the tool axis is within a few cones of this place.
    double turn_near(std::size_t i) const {
        const auto from = std::lower_bound(way_.begin(), way_.end(), way_[i] - kReach * cone_) - way_.begin();
        const auto to = std::upper_bound(way_.begin(), way_.end(), way_[i + 1] + kReach * cone_) - way_.begin() - 1;
        // Resting at the pole the azimuth is noise.
        if (way_[static_cast<std::size_t>(to)] - way_[static_cast<std::size_t>(from)] < 1e-6) return 0.0;
        return azimuth_[static_cast<std::size_t>(to)] - azimuth_[static_cast<std::size_t>(from)];
    }

    std::span<Vec3> axes_;
    Vec3 pole_;
    double cone_;
    std::vector<double> way_, azimuth_;
};

}  // namespace

Vec3 singular_axis(const Machine& machine) {
    const detail::Chain chain(machine);
    return machine.rotary[chain.outer()].direction;
}

Detours go_round_singularity(std::span<const Vec3> axes, std::span<const AxisRun> runs, const Machine& machine, double cone) {
    TRUNNION_REQUIRE(cone > 0 && cone < 0.5);
    Detours found;
    found.axis.assign(axes.begin(), axes.end());
    const Vec3 pole = singular_axis(machine);
    for (const AxisRun& run : runs) {
        TRUNNION_REQUIRE(run.first + run.count <= axes.size());
        const std::span<Vec3> own = std::span(found.axis).subspan(run.first, run.count);
        for (const double side : {1.0, -1.0}) {
            std::vector<Vec3> before(own.begin(), own.end());
            Run work(own, side * pole, cone);
            int dips = 0;
            while (dips < kMostDips && work.go_round_one()) ++dips;
            double change = 0.0;
            for (std::size_t i = 0; i < own.size(); ++i) change = std::max(change, angle_between(before[i], own[i]));
            // Leans that add up to more than was allowed help nobody.
            if (dips == kMostDips || change > cone * kMostLean) std::copy(before.begin(), before.end(), own.begin());
        }
        std::size_t first = run.count, last = 0;
        for (std::size_t i = 0; i < run.count; ++i) {
            const double change = angle_between(axes[run.first + i], own[i]);
            if (!(change > 0)) continue;
            found.largest_change = std::max(found.largest_change, change);
            first = std::min(first, i);
            last = i;
        }
        if (first < run.count) found.where.push_back({run.first + first, last - first + 1});
    }
    return found;
}

}  // namespace trunnion
