#include <algorithm>

#include <fmt/format.h>

#include "path/sampling.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/path/pattern.hpp"

namespace trunnion {

namespace {

/// One iso-line of a face as a curve of its running parameter.
Curve iso_line(const Surface& surface, bool along_u, double fixed) {
    return [&surface, along_u, fixed](const std::vector<double>& t) {
        const std::vector<double> other(t.size(), fixed);
        const std::vector<double>&u = along_u ? t : other, &v = along_u ? other : t;
        SurfaceBatch batch;
        surface.evaluate(u, v, 1, batch);
        std::vector<CurvePoint> points(t.size());
        for (std::size_t i = 0; i < t.size(); ++i) {
            CurvePoint& p = points[i];
            p.p = batch.point(i);
            p.uv = {u[i], v[i]};
            const Vec3 su(batch.plane(3)[i], batch.plane(4)[i], batch.plane(5)[i]),
                sv(batch.plane(6)[i], batch.plane(7)[i], batch.plane(8)[i]);
            const Vec3 cross = surface.normal_sign() * su.cross(sv);
            // Near a pole the cross product fades to rounding; the surface then finds the limit itself.
            constexpr double kFaded = 1e-8;
            if (cross.norm() > kFaded * su.norm() * sv.norm() && cross.norm() > 0.0) {
                p.n = cross.normalized();
            } else {
                const auto n = surface.normal(u[i], v[i]);
                p.regular = n.has_value();
                if (n) p.n = *n;
            }
        }
        return points;
    };
}

struct Across {
    Interval range;       // of the fixed parameter
    bool closed = false;  // its two ends are the same curve
};

/// Range of the fixed parameter that the trimmed face covers.
Across across_range(const Face& face, bool along_u) {
    const Domain& domain = face.surface->domain();
    Across across{along_u ? domain.v : domain.u, (along_u ? domain.closed_v : domain.closed_u)};
    if (face.trim.whole_domain()) return across;
    Interval seen{across.range.hi, across.range.lo};
    for (const auto& loop : face.trim.loops())
        for (const Vec2& uv : loop) {
            const double x = along_u ? uv.y() : uv.x();
            seen = {std::min(seen.lo, x), std::max(seen.hi, x)};
        }
    constexpr double kWhole = 1e-9;
    across.closed = across.closed && seen.length() > (1.0 - kWhole) * across.range.length();
    across.range = {std::max(across.range.lo, seen.lo), std::min(across.range.hi, seen.hi)};
    return across;
}

std::vector<Interval> runs_of(const Face& face, bool along_u, double fixed) {
    const Domain& domain = face.surface->domain();
    const Interval range = along_u ? domain.u : domain.v;
    if (face.trim.whole_domain()) return {range};
    return face.trim.inside(along_u, fixed, range);
}

class FacePlanner {
public:
    FacePlanner(const Isoparametric& how, const PathScene& scene, const Face& face)
        : how_(how), scene_(scene), face_(face), surface_(*face.surface) {
        limits_ = {scene.tolerance.chord, scene.tolerance.angle, how.step, 0.5 * scene.cutter.spec().diameter};
        scallop_ = how.scallop > 0.0 ? how.scallop : scene.tolerance.scallop;
    }

    /// Fixed parameters of the passes, in machining order.
    Result<std::vector<double>> positions(const Control& control) const {
        Across across = across_range(face_, how_.along_u);
        if (how_.margin > 0.0 && !across.closed) across.range = shrink_across(across.range);
        if (!(across.range.hi >= across.range.lo))
            return fail(ErrorCode::no_solution,
                        fmt::format("a margin of {:.6g} mm leaves nothing between the first and the last pass", how_.margin));
        std::vector<double> q;
        if (how_.passes == 1) {
            q.push_back(across.range.mid());
        } else if (how_.passes > 1) {
            const int intervals = across.closed ? how_.passes : how_.passes - 1;
            for (int i = 0; i < how_.passes; ++i) q.push_back(across.range.at(static_cast<double>(i) / intervals));
        } else {
            auto spaced = by_scallop(across, control);
            if (!spaced) return spaced;
            q = std::move(*spaced);
        }
        if (how_.reverse) std::reverse(q.begin(), q.end());
        return q;
    }

    /// The contacts of the pass at `fixed`, in runs where the border cuts it.
    ContactPath pass(double fixed, bool backwards) const {
        ContactPath path;
        const Curve curve = iso_line(surface_, how_.along_u, fixed);
        std::vector<Interval> runs = runs_of(face_, how_.along_u, fixed);
        if (backwards) std::reverse(runs.begin(), runs.end());
        const Domain& domain = surface_.domain();
        const bool whole_turn = (how_.along_u ? domain.closed_u : domain.closed_v) && runs.size() == 1 && how_.margin <= 0.0 &&
                                runs.front().length() >= (how_.along_u ? domain.u : domain.v).length();
        for (const Interval& run : runs) {
            const Interval kept = whole_turn ? run : shrink(curve, run, how_.margin);
            if (!(kept.hi > kept.lo)) continue;
            // A line that has shrunk to a point (a pole) is no pass.
            if (curve_length(curve, kept) <= 0.01 * scene_.tolerance.chord) continue;
            std::vector<double> t = sample_curve(curve, kept, limits_);
            if (backwards) std::reverse(t.begin(), t.end());
            std::vector<Vec3> cc, n;
            std::vector<Vec2> uv;
            for (const CurvePoint& p : curve(t)) {
                if (!p.regular) continue;
                cc.push_back(p.p);
                n.push_back(p.n);
                uv.push_back(p.uv);
            }
            append_pass(path, cc, n, uv, std::vector<std::int32_t>(cc.size(), face_.index), whole_turn);
        }
        return path;
    }

private:
    /// The range shortened so that the outermost passes keep the margin from the border everywhere.
    Interval shrink_across(const Interval& range) const {
        Interval kept = range;
        const Domain& domain = surface_.domain();
        const Interval along = how_.along_u ? domain.u : domain.v;
        constexpr int kLines = 17;
        for (int i = 0; i < kLines; ++i) {
            const Curve line = iso_line(surface_, !how_.along_u, along.at(static_cast<double>(i) / (kLines - 1)));
            if (curve_length(line, range) < 4.0 * how_.margin) continue;  // a pole or a narrow end: it has no say
            const Interval one = shrink(line, range, how_.margin);
            kept = {std::max(kept.lo, one.lo), std::min(kept.hi, one.hi)};
        }
        return kept;
    }

    /// Greatest step of the fixed parameter from a pass at q (towards q + 1 or q - 1) that keeps the scallop everywhere.
    double greatest_step(double q) const {
        double step = std::numeric_limits<double>::infinity();
        constexpr std::size_t kSamples = 49;
        const std::vector<double> fixed(kSamples, q);
        std::vector<double> running(kSamples);
        SurfaceBatch batch;
        for (const Interval& run : runs_of(face_, how_.along_u, q)) {
            for (std::size_t i = 0; i < kSamples; ++i) running[i] = run.at(static_cast<double>(i) / (kSamples - 1));
            surface_.evaluate(how_.along_u ? running : fixed, how_.along_u ? fixed : running, 2, batch);
            for (std::size_t i = 0; i < kSamples; ++i) {
                const SurfacePoint p = batch.at(i);
                const Vec3 along = how_.along_u ? p.Su : p.Sv, over = how_.along_u ? p.Sv : p.Su;
                const Vec3 cross = p.Su.cross(p.Sv);
                if (!(cross.norm() > 1e-8 * p.Su.norm() * p.Sv.norm()) || cross.norm() == 0.0) continue;
                const Vec3 n = surface_.normal_sign() * cross.normalized(), f = along.normalized(), b = n.cross(f);
                const double width = section_width(scene_.cutter, scene_.lead, scene_.tilt, curvatures(p, n, f, b).kb, scallop_);
                if (width > 0.0) step = std::min(step, width / std::abs(over.dot(b)));
            }
        }
        return step;
    }

    Result<std::vector<double>> by_scallop(const Across& across, const Control& control) const {
        constexpr std::size_t kMostPasses = 100'000;
        const double end = across.range.hi, least = 1e-9 * across.range.length();
        std::vector<double> q{across.range.lo};
        while (q.back() < end) {
            if (control.cancelled()) return fail_cancelled("spacing the passes");
            double step = std::min(greatest_step(q.back()), across.range.length());
            // The next pass must be as far from this one as both allow.
            for (int i = 0; i < 4; ++i) {
                const double back = std::max(greatest_step(std::min(end, q.back() + step)), 0.5 * step);
                if (back >= step) break;
                step = back;
            }
            if (!(step > least))
                return fail(ErrorCode::no_solution, fmt::format("no pass spacing keeps a scallop of {:.6g} mm: the surface is "
                                                                "more curved than the cutter at parameter {:.6g}",
                                                                scallop_, q.back()));
            q.push_back(q.back() + step);
            if (q.size() > kMostPasses)
                return fail(ErrorCode::invalid_input,
                            fmt::format("a scallop of {:.6g} mm needs more than {} passes", scallop_, kMostPasses));
        }
        // The last pass overshoots the end: draw all of them together so that it falls on it.
        const double scale = across.range.length() / (q.back() - q.front());
        for (double& x : q) x = across.range.lo + scale * (x - across.range.lo);
        if (across.closed) q.pop_back();
        return q;
    }

    const Isoparametric& how_;
    const PathScene& scene_;
    const Face& face_;
    const Surface& surface_;
    SampleLimits limits_;
    double scallop_ = 0.0;
};

}  // namespace

Result<ContactPath> Isoparametric::operator()(const PathScene& scene, const Control& control) const {
    ContactPath path;
    std::size_t pass = 0;
    for (std::size_t k = 0; k < scene.faces.size(); ++k) {
        const Face& face = scene.part.faces[static_cast<std::size_t>(scene.faces[k])];
        const std::string where = fmt::format("face {}", face.index);
        if (!face.surface)
            return fail(ErrorCode::unsupported, where + ": it is a mesh and has no parameters; use pattern = \"parallel\"");
        const FacePlanner planner(*this, scene, face);
        auto positions = planner.positions(control);
        if (!positions) return fail_in(std::move(positions), where);
        std::vector<ContactPath> lines(positions->size());
        auto done = parallel_for(lines.size(), 1, control, "path", [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) lines[i] = planner.pass((*positions)[i], zigzag && (pass + i) % 2 == 1);
        });
        if (!done) return fail_up(std::move(done));
        pass += lines.size();
        for (const ContactPath& one : lines) append_path(path, one);
    }
    return path;
}

}  // namespace trunnion
