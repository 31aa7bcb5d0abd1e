// The two rays: closed forms of sections 3 and 5, with derivatives.
#include "pose/multipoint_impl.hpp"

namespace trunnion::detail {

std::optional<Jet> touch_height(const ToolShape& tool, const Vec3& ex, const Vec3& ey, const Vec3& ez,
                                const SurfacePoint& from_o) {
    const Jet X = along(from_o, ex), Y = along(from_o, ey), Z = along(from_o, ez);
    const Jet r2 = X * X + Y * Y;
    const double rho = std::sqrt(r2.f);
    if (!tool.open && rho <= tool.Ro) return Z + tool.Ri;
    if (tool.Ro == 0.0) {
        const Jet q = tool.Ri * tool.Ri - r2;
        return q.f > 0.0 ? std::optional<Jet>(Z + sqrt(q)) : std::nullopt;
    }
    if (!(rho > 0.0)) return std::nullopt;
    const Jet t = sqrt(r2) - tool.Ro;
    const Jet q = tool.Ri * tool.Ri - t * t;
    return q.f > 0.0 ? std::optional<Jet>(Z + sqrt(q)) : std::nullopt;
}

namespace {

/// The place on the point's circle about the insert line where it meets a part of the tool.
struct Entry {
    Jet v, w;
};

struct Turn {
    const ToolShape& tool;
    Jet u, v, w, b, R2, over;  ///< over: R^2 - Ri^2 without cancellation

    std::optional<Entry> torus(bool up) const {
        if (!(b.f > 0.0)) return std::nullopt;
        const Jet vs = tool.Ro + (0.25 / tool.Ro) * b - tool.Ro * (u * u / b);
        const Jet h2 = R2 - vs * vs;
        if (!(h2.f > 0.0)) return std::nullopt;
        const Jet h = sqrt(h2);
        return Entry{vs, up ? -h : h};
    }
    std::optional<Entry> disc() const {
        if (!(over.f > 0.0)) return std::nullopt;
        const Jet vd = sqrt(over);
        if (u.f * u.f + (vd.f - tool.Ro) * (vd.f - tool.Ro) > tool.Ro * tool.Ro) return std::nullopt;
        return Entry{vd, Jet(-tool.Ri)};
    }
    /// The far wall when turning up, the near one otherwise.
    std::optional<Entry> shank(bool up) const {
        const double D2 = tool.Ro + tool.Ri;
        const Jet q = D2 * D2 - u * u;
        if (!(q.f > 0.0)) return std::nullopt;
        const Jet half = sqrt(q), vf = up ? tool.Ro + half : tool.Ro - half;
        const Jet h2 = R2 - vf * vf;
        if (!(h2.f > 0.0) || h2.f > tool.top * tool.top) return std::nullopt;
        return Entry{vf, sqrt(h2)};
    }
    double angle(const Entry& e, bool up) const {
        const double turn = std::atan2(v.f * e.w.f - w.f * e.v.f, v.f * e.v.f + w.f * e.w.f), signed_turn = up ? turn : -turn;
        constexpr double kTouching = 1e-6;  // rad: a second contact at the start may lie this deep by rounding
        return signed_turn < -kTouching ? signed_turn + 2.0 * kPi : signed_turn;
    }
    Jet angle_jet(const Entry& e, bool up, double angle) const {
        Jet turn = angle_of(v * e.w - w * e.v, v * e.v + w * e.w);
        if (!up) turn = -turn;
        turn.f = angle;
        return turn;
    }
};

}  // namespace

std::optional<Jet> turn_until(const ToolShape& tool, const Insert& frame, const SurfacePoint& d, bool up, Part2* part) {
    const Vec3 to_P = frame.P - frame.O1;
    const Jet x = along(d, Vec3::UnitX()), y = along(d, Vec3::UnitY()), z = along(d, Vec3::UnitZ());
    Turn turn{tool,
              along(d, frame.eu),
              along(d, frame.ev) + frame.Pv,
              along(d, frame.ew) + frame.Pw,
              x * x + y * y + z * z + 2.0 * along(d, to_P),
              Jet(),
              Jet()};
    turn.over = turn.b - turn.u * turn.u;
    turn.R2 = turn.over + tool.Ri * tool.Ri;
    std::optional<Entry> best;
    double least = std::numeric_limits<double>::infinity();
    Part2 which = Part2::none;
    const auto offer = [&](const std::optional<Entry>& e, Part2 kind) {
        if (!e) return;
        const double a = turn.angle(*e, up);
        if (a < least) least = a, best = e, which = kind;
    };
    if (tool.Ri > 0.0) offer(turn.torus(up), Part2::torus);
    if (up && !tool.open) offer(turn.disc(), Part2::disc);
    offer(turn.shank(up), Part2::shank);
    if (part) *part = which;
    if (!best) return std::nullopt;
    return turn.angle_jet(*best, up, least);
}

}  // namespace trunnion::detail
