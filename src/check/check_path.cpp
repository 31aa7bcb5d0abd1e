#include <algorithm>

#include <fmt/format.h>

#include "check/engine.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion {

namespace detail {
struct CheckedPathMaker {
    static CheckedPath subdivide(const CheckedPath& path, const std::vector<int>& pieces) {
        CheckedPath out;
        out.claims_ = path.claims_;
        out.axis_slack_ = path.axis_slack_;
        out.link_axis_slack_ = path.link_axis_slack_;
        out.valid_ = path.valid_;
        for (const Pass& pass : path.poses_.passes) {
            const std::size_t first = out.poses_.size();
            for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
                for (int k = 1; i > 0 && k < pieces[i]; ++k) between(path, i, static_cast<double>(k) / pieces[i], out);
                out.poses_.cl.push_back(path.poses_.cl[i]);
                out.poses_.axis.push_back(path.poses_.axis[i]);
                out.poses_.contact.push_back(path.poses_.contact[i]);
                out.verdicts_.push_back(path.verdicts_[i]);
                out.link_.push_back(path.link_[i]);
            }
            out.poses_.passes.push_back({first, out.poses_.size() - first, pass.kind, pass.rapid});
        }
        return out;
    }

private:
    static void between(const CheckedPath& path, std::size_t i, double t, CheckedPath& out) {
        const PosePath& p = path.poses_;
        out.poses_.cl.push_back(p.cl[i - 1] + t * (p.cl[i] - p.cl[i - 1]));
        out.poses_.axis.push_back(slerp(p.axis[i - 1], p.axis[i], t));
        out.poses_.contact.push_back(p.contact[i] >= 0 && p.contact[i - 1] >= 0 ? kOnChord : kNoContact);
        Verdict v = path.verdicts_[i];
        v.gouge = v.motion_gouge;
        v.clearance = v.motion_clearance;
        out.verdicts_.push_back(std::move(v));
        out.link_.push_back(path.link_[i]);
    }

public:
    static CheckedPath make(PosePath poses, std::vector<Verdict> verdicts, std::vector<Claim> claims, std::vector<bool> link,
                            const CheckOptions& options) {
        CheckedPath path;
        path.valid_ = std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.valid; });
        path.poses_ = std::move(poses);
        path.verdicts_ = std::move(verdicts);
        path.claims_ = std::move(claims);
        path.link_ = std::move(link);
        path.axis_slack_ = options.axis_slack;
        path.link_axis_slack_ = options.link_axis_slack;
        return path;
    }
};
}  // namespace detail

namespace {

constexpr std::size_t kGrain = 64;  // poses per chunk: hints run on within it, results do not depend on threads

Result<void> validate(const PosePath& path, std::size_t contacts) {
    const auto wrong = [](std::string m) { return fail(ErrorCode::invalid_input, "pose path: " + std::move(m)); };
    const std::size_t n = path.cl.size();
    if (path.axis.size() != n || path.contact.size() != n)
        return wrong(fmt::format("{} tips but {} axes and {} contact indices", n, path.axis.size(), path.contact.size()));
    if (contacts != 0 && contacts != n) return wrong(fmt::format("{} poses but {} contact points", n, contacts));
    std::size_t covered = 0;
    for (const Pass& pass : path.passes) {
        if (pass.first != covered) return wrong(fmt::format("pass starting at pose {} leaves a gap", pass.first));
        covered += pass.count;
    }
    if (covered != n) return wrong(fmt::format("its passes cover {} of {} poses", covered, n));
    constexpr double kUnit = 1e-9;
    for (std::size_t i = 0; i < n; ++i) {
        if (!path.cl[i].allFinite() || !path.axis[i].allFinite()) return wrong(fmt::format("pose {} is not finite", i));
        if (std::abs(path.axis[i].norm() - 1.0) > kUnit)
            return wrong(fmt::format("axis of pose {} has length {:.12g}, not 1", i, path.axis[i].norm()));
    }
    return {};
}

/// Per pose, what kind of motion leads to it.
struct Motions {
    std::vector<bool> rapid, link;
    explicit Motions(const PosePath& path) : rapid(path.size(), false), link(path.size(), false) {
        for (const Pass& pass : path.passes)
            for (std::size_t i = pass.first; i < pass.first + pass.count; ++i) {
                rapid[i] = pass.rapid;
                link[i] = pass.kind == PassKind::link;
            }
    }
};

std::string where(const CheckScene& scene, const Place& place) {
    const std::string at = fmt::format("({:.3f}, {:.3f}, {:.3f})", place.point.x(), place.point.y(), place.point.z());
    if (place.body >= 0) return fmt::format("check body {} at {}", scene.bodies()[static_cast<std::size_t>(place.body)].name, at);
    return place.face >= 0 ? fmt::format("face {} at {}", place.face, at) : fmt::format("the part at {}", at);
}

/// A piece touches the machined part on purpose only with its cutting part.
struct Limits {
    double pose = 0.0;    // least distance at a pose
    double motion = 0.0;  // least distance on the way
};
Limits limits_of(PieceKind kind, bool rapid, const CheckOptions& o) {
    if (kind == PieceKind::cutter && rapid) return {o.rapid_clearance, o.rapid_clearance - o.chord};
    if (kind == PieceKind::cutter) return {-o.gouge, -(o.gouge + o.chord)};
    return {o.clearance, o.clearance - o.chord};
}

/// Keeps the first reason, and the place of it.
void reject(Verdict& verdict, std::string why, const Place& place) {
    if (!verdict.valid) return;
    verdict.valid = false;
    verdict.why = std::move(why);
    verdict.place = place;
}

class Checker {
public:
    Checker(const PosePath& path, const Motions& motions, const Cutter& cutter, const CheckScene& scene,
            const CheckOptions& options, std::span<const std::optional<Vec3>> contacts)
        : path_(path), motions_(motions), cutter_(cutter), scene_(scene), options_(options), contacts_(contacts) {}

    void chunk(std::size_t begin, std::size_t end, std::vector<Verdict>& verdicts) const {
        std::vector<std::uint32_t> nearest(cutter_.pieces().size(), PieceDistance::kNoTriangle);
        CellStore cells(scene_.index());
        for (std::size_t i = begin; i < end; ++i) {
            if (const auto why = options_.refused.find(path_.contact[i]); why != options_.refused.end()) {
                Place place;
                place.point = path_.cl[i];
                reject(verdicts[i], why->second, place);
            }
            at_pose(i, cells, nearest, verdicts[i]);
            if (i > 0) on_the_way(i, cells, verdicts[i]);
        }
    }

private:
    void at_pose(std::size_t i, CellStore& cells, std::vector<std::uint32_t>& nearest, Verdict& verdict) const {
        verdict.clearance = options_.clearance_cap;
        for (std::size_t k = 0; k < cutter_.pieces().size(); ++k) {
            const ToolPiece& piece = cutter_.pieces()[k];
            const Limits limit = limits_of(piece.kind, motions_.rapid[i], options_);
            const bool cutting = piece.kind == PieceKind::cutter;
            // The proved bound may lose a tenth of the tolerance to the gap; holders are judged to the chord tolerance.
            const double gap = cutting ? 0.1 * options_.gouge : 0.1 * std::max(options_.chord, 1e-3 * options_.clearance);
            DistanceHint hint;
            hint.triangle = nearest[k];
            if (cutting && !contacts_.empty()) hint.point = contacts_[i];
            const PieceDistance d =
                piece_distance(cells, cutter_, k, path_.cl[i], path_.axis[i], gap, options_.clearance_cap, limit.pose, hint);
            nearest[k] = d.triangle;
            if (cutting) {
                verdict.gouge = -d.lower;
                if (d.lower < (path_.contact[i] == kOnChord ? limit.motion : limit.pose))
                    reject(verdict, cut_text(d, motions_.rapid[i]), d.place);
            } else {
                verdict.clearance = std::min(verdict.clearance, d.lower);
                if (d.lower < (path_.contact[i] == kOnChord ? limit.motion : limit.pose))
                    reject(verdict, too_close(piece, d, options_.clearance), d.place);
            }
        }
        if (i == 0) not_inside(verdict);
    }

    void on_the_way(std::size_t i, CellStore& cells, Verdict& verdict) const {
        verdict.motion_gouge = -std::numeric_limits<double>::infinity();
        verdict.motion_clearance = options_.clearance_cap;
        for (std::size_t k = 0; k < cutter_.pieces().size(); ++k) {
            const ToolPiece& piece = cutter_.pieces()[k];
            const Limits limit = limits_of(piece.kind, motions_.rapid[i], options_);
            const bool cutting = piece.kind == PieceKind::cutter;
            const PieceDistance d =
                motion_distance(cells, cutter_, k, path_.cl[i - 1], path_.axis[i - 1], path_.cl[i], path_.axis[i],
                                motions_.link[i] ? options_.link_axis_slack : options_.axis_slack, limit.motion);
            if (cutting) {
                verdict.motion_gouge = -std::min(d.lower, options_.clearance_cap);
                if (d.lower < limit.motion)
                    reject(verdict, "on the way from the pose before, " + cut_text(d, motions_.rapid[i]), d.place);
            } else {
                verdict.motion_clearance = std::min(verdict.motion_clearance, d.lower);
                if (d.lower < limit.motion)
                    reject(verdict, "on the way from the pose before, " + too_close(piece, d, options_.clearance), d.place);
            }
        }
    }

    /// No surface crosses the tool where all distances are positive: then one point tells whether it stands in a body.
    void not_inside(Verdict& verdict) const {
        const Profile& profile = cutter_.pieces().front().profile;
        const double middle = 0.5 * (profile.height_lo() + profile.height_hi());
        const auto body = scene_.inside_which(path_.cl.front() + middle * path_.axis.front());
        if (!body) return;
        Place place;
        place.point = path_.cl.front();
        place.body = *body;
        place.tool_piece = "cutter";
        reject(verdict,
               *body < 0
                   ? std::string("the tool starts inside the part")
                   : fmt::format("the tool starts inside check body {}", scene_.bodies()[static_cast<std::size_t>(*body)].name),
               place);
    }

    std::string cut_text(const PieceDistance& d, bool rapid) const {
        // What was found, unless only the proof falls short of the limit.
        const double distance =
            std::min(d.upper, rapid ? options_.rapid_clearance : -options_.gouge) == d.upper ? d.upper : d.lower;
        if (distance < 0.0) return fmt::format("the cutter is {:.4g} mm deep in {}", -distance, where(scene_, d.place));
        return fmt::format("the cutter comes within {:.4g} mm of {} at rapid speed, {:.4g} mm wanted", distance,
                           where(scene_, d.place), options_.rapid_clearance);
    }

    std::string too_close(const ToolPiece& piece, const PieceDistance& d, double wanted) const {
        const double distance = std::min(d.upper, d.lower);
        if (distance < 0.0) return fmt::format("the {} is {:.4g} mm deep in {}", piece.name, -distance, where(scene_, d.place));
        return fmt::format("the {} comes within {:.4g} mm of {}, {:.4g} mm wanted", piece.name, distance, where(scene_, d.place),
                           wanted);
    }

    const PosePath& path_;
    const Motions& motions_;
    const Cutter& cutter_;
    const CheckScene& scene_;
    const CheckOptions& options_;
    std::span<const std::optional<Vec3>> contacts_;
};

std::vector<Claim> claims_for(const Cutter& cutter, const CheckScene& scene, const CheckOptions& o, const PosePath& path,
                              const std::vector<Verdict>& verdicts) {
    double gouge = -std::numeric_limits<double>::infinity(), motion = gouge, clearance = o.clearance_cap;
    std::size_t bad = 0;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
        if (path.contact[i] != kOnChord) gouge = std::max(gouge, verdicts[i].gouge);
        if (i > 0) motion = std::max(motion, verdicts[i].motion_gouge);
        clearance = std::min(clearance, verdicts[i].clearance);
        bad += verdicts[i].valid ? 0 : 1;
    }
    bool exact = false;
    double trim = 0.0;
    for (const Face& face : scene.part().faces) {
        exact = exact || face.surface;
        trim = std::max(trim, face.trim.chord_error());
    }
    const std::string on = exact ? fmt::format("on the exact surfaces (face borders followed to {:.3g} mm)", std::max(trim, 0.0))
                                 : std::string("on the triangles of the file");
    const char* engine = "box tree with convex bounds, certified";
    std::vector<Claim> claims;
    claims.push_back({"depth of the cutter below the part at the poses", fmt::format("<= {:.4g} mm {}", std::max(gouge, 0.0), on),
                      engine, gouge <= o.gouge});
    claims.push_back({"depth of the cutter on the straight moves between poses",
                      fmt::format("<= {:.4g} mm {}, any axis within {:.3g} deg of the great circle", std::max(motion, 0.0), on,
                                  degrees(o.axis_slack)),
                      engine, motion <= o.gouge + o.chord});
    if (cutter.pieces().size() > 1)
        claims.push_back({"clearance of shank and holder at the poses",
                          fmt::format(">= {:.4g} mm{}", clearance, clearance >= o.clearance_cap ? " (not measured above)" : ""),
                          engine, clearance >= o.clearance});
    claims.push_back(
        {"every pose and every move", fmt::format("{} of {} valid", verdicts.size() - bad, verdicts.size()), engine, bad == 0});
    return claims;
}

}  // namespace

CheckedPath subdivide(const CheckedPath& path, const std::vector<int>& pieces) {
    TRUNNION_REQUIRE(pieces.size() == path.poses().size());
    return detail::CheckedPathMaker::subdivide(path, pieces);
}

bool is_clear(const PosePath& path, const Cutter& cutter, const CheckScene& scene, const CheckOptions& options) {
    if (!validate(path, 0)) return false;
    const Motions motions(path);
    const Checker checker(path, motions, cutter, scene, options, {});
    std::vector<Verdict> verdicts(path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
        checker.chunk(i, i + 1, verdicts);
        if (!verdicts[i].valid) return false;
    }
    return true;
}

Result<CheckedPath> check_path(const PosePath& path, const Cutter& cutter, const CheckScene& scene, const CheckOptions& options,
                               const Control& control, std::span<const std::optional<Vec3>> contacts) {
    if (auto ok = validate(path, contacts.size()); !ok) return fail_up(std::move(ok));
    std::vector<Verdict> verdicts(path.size());
    Motions motions(path);
    const Checker checker(path, motions, cutter, scene, options, contacts);
    auto done = parallel_for(path.size(), kGrain, control, "checking",
                             [&](std::size_t begin, std::size_t end) { checker.chunk(begin, end, verdicts); });
    if (!done) return fail_up(std::move(done));
    auto claims = claims_for(cutter, scene, options, path, verdicts);
    return detail::CheckedPathMaker::make(path, std::move(verdicts), std::move(claims), std::move(motions.link), options);
}

}  // namespace trunnion
