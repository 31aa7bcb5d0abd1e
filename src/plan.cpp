#include "trunnion/plan.hpp"

#include <algorithm>
#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "axis_measures.hpp"
#include "outcome.hpp"
#include "setup.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/machine/timing.hpp"
#include "trunnion/path/strip.hpp"
#include "trunnion/report/html.hpp"

namespace trunnion {

using nlohmann::ordered_json;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Wall time per stage.
class Stopwatch {
public:
    void stage(std::string name) {
        stop();
        name_ = std::move(name);
        start_ = std::chrono::steady_clock::now();
    }
    void stop() {
        if (name_.empty()) return;
        times_[name_] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        name_.clear();
    }
    const std::map<std::string, double>& times() const { return times_; }

private:
    std::string name_;
    std::chrono::steady_clock::time_point start_;
    std::map<std::string, double> times_;
};

Box3 whole_box(const Setup& s) {
    Box3 box = s.part->box;
    for (const CheckBody& body : s.bodies) box.add(body.part->box);
    return box;
}

/// How far the tool reaches below its tip, seen along a direction that its axis makes the cosine with.
double dip(const Cutter& cutter, double cosine) {
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    double deepest = 0.0;
    for (const ToolPiece& piece : cutter.pieces())
        for (const ProfileSegment& side : piece.profile.outer())
            for (const Vec2& p : {side.from, side.to}) deepest = std::max(deepest, p.x() * sine - p.y() * cosine);
    return deepest;
}

/// A plane above everything while all tools lean up from it by at least 12 degrees; else a sphere around everything. Far enough
/// out that a leaning holder stays clear too.
ClearanceSurface clearance_surface(const Job& job, const Setup& s, const PosePath& cuts) {
    if (job.clearance_surface) return *job.clearance_surface;
    constexpr double kLeastRise = 0.2;
    const Box3 box = whole_box(s);
    double rise = 1.0;
    for (const Vec3& T : cuts.axis) rise = std::min(rise, T.z());
    if (rise >= kLeastRise) return ClearancePlane{Vec3::UnitZ(), box.hi.z() + job.link_margin + dip(s.cutter, rise)};
    // Where a ray along T from inside meets the sphere, T makes at least the angle of the least favourable pose there with the
    // radius.
    ClearanceSphere sphere{box.centre(), 0.5 * box.diagonal() + job.link_margin};
    double least = 1.0;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
        const Vec3 a = cuts.cl[i] - sphere.centre;
        const double along = a.dot(cuts.axis[i]), across2 = std::max(0.0, a.squaredNorm() - along * along);
        least = std::min(least, std::sqrt(std::max(0.0, 1.0 - across2 / (sphere.radius * sphere.radius))));
    }
    sphere.radius += dip(s.cutter, least);
    return sphere;
}

std::vector<std::optional<Vec3>> contact_points(const PosePath& poses, const ContactPath& contacts) {
    std::vector<std::optional<Vec3>> points(poses.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        if (poses.contact[i] >= 0) points[i] = contacts.cc[static_cast<std::size_t>(poses.contact[i])];
    return points;
}

/// On a mesh the smoothed normals leave the tool a little deep in the facets: it is raised along its axis until it only
/// touches. Raising by depth / (n . T) lifts the contact by its depth; two or three rounds settle.
Result<void> lift_off_facets(PosePath& cuts, const ContactPath& contacts, const Setup& s, const Control& control) {
    constexpr int kRounds = 12;
    constexpr double kLeastCosine = 0.2;
    return parallel_for(cuts.size(), 64, control, "lifting off the facets", [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3& T = cuts.axis[i];
            const double cosine = std::max(kLeastCosine, contacts.n[static_cast<std::size_t>(cuts.contact[i])].dot(T));
            DistanceHint hint;
            for (int round = 0; round < kRounds; ++round) {
                const PieceDistance d =
                    piece_distance(s.scene, s.cutter, 0, cuts.cl[i], T, 0.1 * s.check.gouge, s.check.gouge, hint);
                if (d.lower >= -0.5 * s.check.gouge) break;
                cuts.cl[i] -= d.lower / cosine * T;
                hint.triangle = d.triangle;
            }
        }
    });
}

/// For every gap between passes the lowest crossing that is clear, or 0 where the tool has to go out to the clearance surface.
Result<std::vector<double>> low_links(const PosePath& cuts, const LinkOptions& links, const Setup& s, const Control& control) {
    const std::vector<double> heights{links.lead, 2.5 * links.lead, 6.0 * links.lead, 15.0 * links.lead};
    std::vector<double> low(cuts.passes.empty() ? 0 : cuts.passes.size() - 1, 0.0);
    auto done = parallel_for(low.size(), 4, control, "links", [&](std::size_t begin, std::size_t end) {
        for (std::size_t gap = begin; gap < end; ++gap)
            for (const double height : heights) {
                if (!is_clear(low_link(cuts, links, gap, height), s.cutter, s.scene, s.check)) continue;
                low[gap] = height;
                break;
            }
    });
    if (!done) return fail_up(std::move(done));
    return low;
}

struct Poses {
    ContactPath contacts;
    PosePath path;
    std::map<std::int64_t, std::string> refused;  // contacts whose axes the method itself takes back
    std::map<std::string, std::string> measured;  // what the method reports: name, JSON object
    std::vector<std::string> notes;               // of the method, its steps and the outcome
    std::vector<MultipointPose> positions;        // of a positioning method, one per contact
    OutcomeReport outcome;
};

/// The job's method with what only the machine or a second surface can say.
Result<Method> resolved_method(const Job& job, const Setup& s) {
    Method method = job.method;
    if (auto* lock = std::get_if<RotaryLock>(&method)) {
        const auto& rotary = s.machine.rotary;
        const std::size_t k = rotary[0].letter == lock->letter ? 0 : 1;
        if (rotary[k].letter != lock->letter)
            return fail(ErrorCode::invalid_input, fmt::format("orientation.rotary = \"{}\": {} has the rotary axes {} and {}",
                                                              lock->letter, s.machine.name, rotary[0].letter, rotary[1].letter));
        const AxisLimits& travel = rotary[k].limits;
        if (!(lock->angle >= travel.lo && lock->angle <= travel.hi))
            return fail(ErrorCode::invalid_input,
                        fmt::format("orientation.angle_deg = {:.6g} leaves the travel of {} of {}, {:.6g} to {:.6g} deg",
                                    degrees(lock->angle), lock->letter, s.machine.name, degrees(travel.lo), degrees(travel.hi)));
        // The other axis carries the tool round a circle: three of its places tell which.
        std::array<Vec3, 3> T;
        for (std::size_t i = 0; i < 3; ++i) {
            JointPosition joints{};
            joints[3 + k] = lock->angle;
            joints[4 - k] = 2.0 * kPi / 3.0 * static_cast<double>(i);
            T[i] = forward(s.machine, joints, s.motion.tool_length).axis;
        }
        const auto pole = UnitVector::from((T[1] - T[0]).cross(T[2] - T[0]));
        lock->cone = pole ? RotaryLock::Cone{*pole, pole->vec().dot(T[0])} : RotaryLock::Cone{T[0], 1.0};
    }
    if (auto* normals = std::get_if<SurfaceNormals>(&method); normals && job.guide) {
        auto surface = make_surface(*job.guide);
        if (!surface) return fail_in(std::move(surface), "orientation.surface");
        if (job.guide->patch_uv) {
            const auto& p = *job.guide->patch_uv;
            surface = surface->restricted({p[0], p[1]}, {p[2], p[3]});
            if (!surface) return fail_in(std::move(surface), "orientation.surface.patch_uv");
        }
        normals->surface = std::move(*surface);
    }
    return method;
}

/// How much shorter than the job's tolerances ask the steps are taken; 1 = not shorter.
struct Steps {
    double chord = 1.0, angle = 1.0;
};

/// How many times denser rows of footprints stand for these steps: a chord's error falls with the square of its length.
int denser(const Steps& steps) {
    return static_cast<int>(std::lround(std::exp2(std::ceil(0.5 * std::log2(1.0 / steps.chord)))));
}

/// Path, orientation, placing and links.
Result<Poses> make_poses(const Job& job, const Setup& s, const Steps& steps, Stopwatch& watch, const Control& control) {
    Tolerance tolerance = job.tolerance;
    tolerance.chord *= steps.chord;
    tolerance.angle *= steps.angle;
    PathScene path_scene{*s.part, s.faces, s.cutter, tolerance};
    if (const auto* sturz = std::get_if<Sturz>(&job.method)) {
        path_scene.lead = sturz->lead;
        path_scene.tilt = sturz->tilt;
    } else if (const auto* rmf = std::get_if<Rmf>(&job.method)) {
        // Not yet known with "auto": a steep tool leaves the highest scallops.
        const LeadTilt start =
            lead_tilt_of(axis_from(InclinationYaw{rmf->inclination.value_or(rmf->greatest_inclination), rmf->yaw.value_or(0.0)},
                                   Vec3::UnitX(), Vec3::UnitZ()),
                         Vec3::UnitX(), Vec3::UnitZ());
        path_scene.lead = start.lead;
        path_scene.tilt = start.tilt;
    } else {
        // The lean is not known before the path is: a steep tool leaves the highest scallops.
        path_scene.lead = radians(75.0);
    }
    Poses poses;
    Result<PosePath> cuts = PosePath{};
    Result<ContactPath> contacts = ContactPath{};
    if (job.positioning) {
        if (!job.cldata_file.empty())
            return fail(ErrorCode::invalid_input,
                        "orientation.method = \"multipoint\" finds contacts of its own and cannot keep those "
                        "of path.pattern = \"cldata\": choose another of the two");
        watch.stage("pose");
        auto placed = position(*job.positioning, job.pattern, path_scene, denser(steps), control);
        if (!placed) return fail_in(std::move(placed), std::string(Multipoint::name));
        contacts = std::move(placed->contacts);
        cuts = std::move(placed->cuts);
        poses.positions = std::move(placed->poses);
        poses.notes = std::move(placed->notes);
    } else {
        watch.stage("path");
        contacts = job.cldata_file.empty() ? plan_path(job.pattern, path_scene, control) : contacts_of_program(job, s, control);
        if (!contacts) return fail_up(std::move(contacts));

        watch.stage("orientation");
        Scene scene{*s.part, s.cutter};
        scene.clearance = [&](std::size_t i, const Vec3& T) { return margin_at(s, *contacts, i, T); };
        scene.refuse = [&](std::size_t i, std::string why) {
            poses.refused.emplace(static_cast<std::int64_t>(i), std::move(why));
        };
        scene.note = [&](std::string what) { poses.notes.push_back(std::move(what)); };
        scene.report = [&](std::string_view name, std::string json) { poses.measured.emplace(name, std::move(json)); };
        auto method = resolved_method(job, s);
        if (!method) return fail_up(std::move(method));
        auto axes = orient(*contacts, *method, scene, control);
        if (!axes) return fail_up(std::move(axes));
        for (const AxisStep& step : job.then) {
            auto next = apply_step(step, *contacts, *axes, scene, control);
            if (!next) return fail_up(std::move(next));
            // What the method took back counts no longer where a step that looks at the pose chose another axis.
            constexpr double kMoved = 1e-9;
            if (std::holds_alternative<ClampAxes>(step) || std::holds_alternative<RepairAxes>(step))
                std::erase_if(poses.refused, [&](const auto& r) {
                    const auto i = static_cast<std::size_t>(r.first);
                    return angle_between((*axes)[i], (*next)[i]) > kMoved;
                });
            axes = std::move(next);
        }
        *axes = away_from_singularity(std::move(*axes), *contacts, job, s, control);
        if (job.outcome == Outcome::trim) {
            auto trimmed = trim(s, *contacts, *axes, poses.refused, control);
            if (!trimmed) return fail_up(std::move(trimmed));
            poses.outcome = std::move(*trimmed);
        }

        watch.stage("pose");
        cuts = place_cutter(*contacts, *axes, s.cutter);
        if (!cuts) return fail_up(std::move(cuts));
        const bool facets = std::any_of(s.faces.begin(), s.faces.end(),
                                        [&](int f) { return !s.part->faces[static_cast<std::size_t>(f)].surface; });
        if (facets)
            if (auto lifted = lift_off_facets(*cuts, *contacts, s, control); !lifted) return fail_up(std::move(lifted));
        if (job.outcome == Outcome::retract) {
            auto drawn = retract(s, *contacts, *cuts, control);
            if (!drawn) return fail_up(std::move(drawn));
            poses.outcome = std::move(*drawn);
        }
    }
    for (std::string& note : poses.outcome.notes) poses.notes.push_back(std::move(note));
    LinkOptions links;
    links.surface = clearance_surface(job, s, *cuts);
    links.lead = job.lead;
    if (job.low_links) {
        auto low = low_links(*cuts, links, s, control);
        if (!low) return fail_up(std::move(low));
        links.low = std::move(*low);
    }
    auto path = link_passes(*cuts, links);
    if (!path) return fail_up(std::move(path));
    poses.contacts = std::move(*contacts);
    poses.path = std::move(*path);
    return poses;
}

/// True where chords alone fail: some move of a cut is too deep although the cutter is clear at both its ends.
bool chords_fail(const CheckedPath& checked, const CheckOptions& limits) {
    const auto& v = checked.verdicts();
    for (std::size_t i = 1; i < v.size(); ++i) {
        const bool cut = checked.poses().contact[i] >= 0 && checked.poses().contact[i - 1] >= 0;
        const bool ends_clear = v[i].gouge <= limits.gouge && v[i - 1].gouge <= limits.gouge;
        if (cut && ends_clear && v[i].motion_gouge > limits.gouge + limits.chord) return true;
    }
    return false;
}

// ---- the document ---------------------------------------------------------------------------------------------------

void fill_poses(PlanDocument& doc, const PosePath& poses, const ContactPath& contacts) {
    const std::size_t n = poses.size();
    for (const Pass& p : poses.passes) doc.passes.push_back({p.first, p.count, std::string(name_of(p.kind))});
    doc.cl = poses.cl;
    doc.axis = poses.axis;
    const Vec3 none = Vec3::Constant(kNaN);
    doc.cc.assign(n, none);
    doc.normal.assign(n, none);
    doc.feed.assign(n, none);
    doc.uv.assign(n, Vec2::Constant(kNaN));
    doc.face.assign(n, -1);
    doc.lead_deg.assign(n, kNaN);
    doc.tilt_deg.assign(n, kNaN);
    doc.given.assign(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
        if (poses.contact[i] < 0) continue;
        const auto k = static_cast<std::size_t>(poses.contact[i]);
        doc.cc[i] = contacts.cc[k];
        doc.normal[i] = contacts.n[k];
        doc.feed[i] = contacts.f[k];
        doc.uv[i] = contacts.uv[k];
        doc.face[i] = contacts.face[k];
        doc.given[i] = contacts.given[k];
        const LeadTilt angles = lead_tilt_of(poses.axis[i], contacts.f[k], contacts.n[k]);
        doc.lead_deg[i] = degrees(angles.lead);
        doc.tilt_deg[i] = degrees(angles.tilt);
    }
}

/// To second order, at the job's scallop height; unknown on mesh faces, and where the cutter is flatter than the surface.
void fill_strip(PlanDocument& doc, const Setup& s, double scallop) {
    doc.strip_width_mm.assign(doc.cl.size(), kNaN);
    for (std::size_t i = 0; i < doc.cl.size(); ++i) {
        if (doc.face[i] < 0 || !doc.uv[i].allFinite()) continue;
        const auto& surface = s.part->faces[static_cast<std::size_t>(doc.face[i])].surface;
        if (!surface) continue;
        const SurfacePoint p = surface->at(doc.uv[i].x(), doc.uv[i].y());
        if (p.Su.cross(p.Sv).isZero(0.0)) continue;  // a pole
        const TangentForm form = surface_form(p, doc.normal[i], doc.feed[i]);
        if (const auto w = strip_width_second_order(s.cutter, form, doc.normal[i], doc.feed[i], doc.axis[i], scallop))
            doc.strip_width_mm[i] = *w;
    }
}

/// What a positioning method knows of each pose.
void fill_positions(PlanDocument& doc, const Poses& poses) {
    if (poses.positions.empty()) return;
    const std::size_t n = poses.path.size();
    doc.second_contact.assign(n, Vec3::Constant(kNaN));
    doc.safe_tilt_deg.assign(n, Vec2::Constant(kNaN));
    doc.status.assign(n, "");
    const auto column = [&](const char* name, auto&& value) {
        std::vector<double>& all = doc.extra[name];
        all.assign(n, kNaN);
        for (std::size_t i = 0; i < n; ++i)
            if (poses.path.contact[i] >= 0) all[i] = value(poses.positions[static_cast<std::size_t>(poses.path.contact[i])]);
    };
    for (std::size_t i = 0; i < n; ++i) {
        if (poses.path.contact[i] < 0) continue;
        const MultipointPose& p = poses.positions[static_cast<std::size_t>(poses.path.contact[i])];
        doc.second_contact[i] = p.Q;
        doc.safe_tilt_deg[i] = {degrees(p.tilt_minus), degrees(p.tilt_plus)};
        doc.status[i] = name_of(p.status);
    }
    using P = const MultipointPose&;
    column("tilt_about_insert_deg", [](P p) { return degrees(p.tilt); });
    column("z_c", [](P p) { return p.z_c; });
    column("separation_mm", [](P p) { return p.separation(); });
    column("k_min_per_mm", [](P p) { return p.k_min; });
    column("certified_gouge_mm", [](P p) { return p.certified_gouge; });
}

void fill_checks(PlanDocument& doc, const CheckedPath& checked) {
    for (const Verdict& v : checked.verdicts()) {
        doc.gouge_mm.push_back(v.gouge);
        doc.motion_gouge_mm.push_back(v.motion_gouge);
        doc.clearance_mm.push_back(v.clearance);
    }
    doc.motion_gouge_mm.front() = kNaN;  // no motion leads to the first pose
    for (const Claim& c : checked.claims()) doc.checks.push_back({c.what, c.bound, c.engine, c.holds});
}

double position_for_file(double value, std::size_t axis) {
    return axis < 3 ? value : degrees(value);
}

void fill_machine(PlanDocument& doc, const MachinePath& m) {
    doc.machine_name = m.machine().name;
    for (const LinearAxis& a : m.machine().linear) doc.axes.emplace_back(1, a.letter);
    for (const RotaryAxis& a : m.machine().rotary) doc.axes.emplace_back(1, a.letter);
    for (const JointPosition& q : m.joints()) {
        std::array<double, 5> p{};
        for (std::size_t k = 0; k < 5; ++k) p[k] = position_for_file(q[k], k);
        doc.positions.push_back(p);
    }
    doc.time_s = m.time();
    for (const double f : m.feed()) doc.feed_mm_min.push_back(60.0 * f);
    doc.branch = m.branch();
    for (const std::string& why : m.why()) {
        doc.valid.push_back(why.empty());
        doc.why.push_back(why);
    }
}

/// Time under the machine's dynamics, and what takes how much of it.
void add_timing(ordered_json& metrics, PlanDocument& doc, const MotionTiming& timing, const MachinePath& m) {
    metrics["time_dynamic_s"] = timing.total;
    metrics["time_dynamic_least_s"] = timing.least;
    metrics["stops"] = timing.stops;
    ordered_json share = ordered_json::object();
    for (std::size_t k = 0; k < timing.share.size(); ++k) {
        const auto kind = k == 0 ? LimitKind::feed : static_cast<LimitKind>((k + 9) / 5);
        const ActiveLimit limit{kind, static_cast<std::uint8_t>(k == 0 ? 0 : (k - 1) % 5)};
        if (timing.share[k] > 0) share[name_of(limit, m.machine())] = timing.share[k];
    }
    metrics["time_share"] = std::move(share);
    // Per pose, on the way to it; the limit as a number: 0 feed, then velocities, accelerations and jerks of the five axes.
    auto &time = doc.extra["dynamic_time_s"], &feed = doc.extra["dynamic_feed_mm_min"], &limit = doc.extra["dynamic_limit"];
    time = timing.time;
    for (std::size_t i = 0; i < timing.feed.size(); ++i) {
        feed.push_back(60.0 * timing.feed[i]);
        const ActiveLimit& l = timing.limit[i];
        limit.push_back(l.kind == LimitKind::none   ? kNaN
                        : l.kind == LimitKind::feed ? 0.0
                                                    : 5.0 * static_cast<double>(l.kind) - 9.0 + l.axis);
    }
}

ordered_json metrics_of(const ContactPath& contacts, const PosePath& poses, const MachinePath& m, const Setup& s) {
    ordered_json j;
    std::size_t cuts = 0, invalid = 0;
    double turn = 0.0, step = 0.0;
    for (const Pass& p : poses.passes) {
        if (p.kind != PassKind::cut) continue;
        ++cuts;
        for (std::size_t i = p.first + 1; i < p.first + p.count; ++i) {
            const double a = angle_between(poses.axis[i - 1], poses.axis[i]);
            turn += a;
            step = std::max(step, a);
        }
    }
    for (const std::string& why : m.why()) invalid += why.empty() ? 0 : 1;
    const auto& t = m.totals();
    j["cut_passes"] = cuts;
    j["contacts"] = contacts.size();
    j["poses"] = poses.size();
    j["invalid_poses"] = invalid;
    j["time_s"] = t.time;
    j["cut_length_mm"] = t.cut_length;
    j["path_length_mm"] = t.length;
    j["axis_variation_deg"] = degrees(turn);
    j["largest_axis_step_deg"] = degrees(step);
    for (std::size_t k = 0; k < 5; ++k) {
        const char letter = k < 3 ? m.machine().linear[k].letter : m.machine().rotary[k - 3].letter;
        const std::string unit = k < 3 ? "mm" : "deg";
        j[fmt::format("travel_{}_{}", letter, unit)] = position_for_file(t.travel[k], k);
        j[fmt::format("top_speed_{}_{}_min", letter, unit)] = 60.0 * position_for_file(t.top_speed[k], k);
    }
    j["least_singularity_sine"] = t.least_sine;
    j["poses_near_singularity"] = t.near_singular;
    j["mesh_triangles"] = s.scene.triangle_count();
    j["mesh_chord_error_mm"] = s.part->mesh.chord_error;
    j["tool_length_mm"] = s.cutter.length();
    return j;
}

std::string summary_of(const PlanDocument& doc, const MachinePath& m, const Job& job, const Setup& s,
                       const ordered_json& metrics) {
    std::string text;
    const auto row = [&](std::string_view name, std::string value) { text += fmt::format("  {:<22}{}\n", name, value); };
    const bool ok = m.valid();
    text += ok ? "VALID\n" : fmt::format("NOT VALID: {} of {} poses\n", metrics["invalid_poses"].get<std::size_t>(), doc.size());
    row("part", fmt::format("{} ({} of {} faces, {})", s.part->file, s.faces.size(), s.part->faces.size(), s.part->unit));
    row("cutter",
        fmt::format("{} D {:.6g} mm, corner {:.6g} mm, length {:.6g} mm with {} of shank and holder", name_of(job.cutter.shape),
                    job.cutter.diameter, s.cutter.tip_corner_radius(), s.cutter.length(), s.cutter.pieces().size() - 1));
    row("machine", fmt::format("{} ({})", m.machine().name, m.machine().title));
    row("passes, poses", fmt::format("{} cuts, {} contacts, {} poses in all", metrics["cut_passes"].get<std::size_t>(),
                                     metrics["contacts"].get<std::size_t>(), doc.size()));
    row("length", fmt::format("{:.1f} mm cutting, {:.1f} mm in all", m.totals().cut_length, m.totals().length));
    row("time", fmt::format("{:.0f} min {:.1f} s (feed and axis speeds)", std::floor(m.totals().time / 60.0),
                            std::fmod(m.totals().time, 60.0)));
    if (metrics.contains("time_dynamic_s")) {
        const double time = metrics["time_dynamic_s"].get<double>();
        std::string most = "nothing";
        double part = 0.0;
        for (const auto& [name, value] : metrics["time_share"].items())
            if (value.get<double>() > part) part = value.get<double>(), most = name;
        row("time, accelerating", fmt::format("{:.0f} min {:.1f} s from rest to rest, {:.0f} % of it limited by the {}",
                                              std::floor(time / 60.0), std::fmod(time, 60.0), 100.0 * part, most));
    }
    for (std::size_t k = 0; k < 2; ++k) {
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (const auto& p : doc.positions) lo = std::min(lo, p[3 + k]), hi = std::max(hi, p[3 + k]);
        row(fmt::format("axis {}", m.machine().rotary[k].letter),
            fmt::format("{:.2f} to {:.2f} deg, {:.1f} deg of travel, top {:.0f} deg/min", lo, hi,
                        degrees(m.totals().travel[3 + k]), degrees(m.totals().top_speed[3 + k]) * 60.0));
    }
    for (const PlanCheck& c : doc.checks) row(c.holds ? "proved" : "NOT HELD", c.what + ": " + c.bound);
    constexpr std::size_t kShown = 5;
    std::size_t shown = 0;
    for (std::size_t i = 0; i < doc.size() && shown < kShown; ++i)
        if (!doc.valid[i]) row(fmt::format("pose {}", i), doc.why[i]), ++shown;
    for (const std::string& w : doc.warnings) row("warning", w);
    return text;
}

ToolOutline outline_of(const Cutter& cutter) {
    ToolOutline outline;
    for (const ToolPiece& p : cutter.pieces()) outline.pieces.push_back({p.name, p.profile.polyline(0.01)});
    return outline;
}

/// Writes, reads back and compares; the text counts as written only then.
Result<std::string> proved_program(const MachinePath& path, ProgramOptions options, PlanDocument& doc) {
    auto text = write_program(path, options);
    if (!text) return text;
    auto back = read_program(*text, options.dialect, &path.machine(), path.options().tool_length);
    if (!back) return tl::unexpected(std::move(back.error()).in(fmt::format("reading the {} program back", options.dialect)));
    auto same = compare_with_path(*back, path);
    if (!same)
        return tl::unexpected(std::move(same.error()).in(fmt::format("comparing the {} program with the plan", options.dialect)));
    doc.checks.push_back(
        {fmt::format("{} program read back against the plan", options.dialect),
         fmt::format("{} blocks, tip within {:.2g} mm, axis within {:.2g} deg", same->blocks, same->tip, degrees(same->axis)),
         "reader of its own, forward kinematics", true});
    return text;
}

PlanDocument blank_document(const Job& job) {
    PlanDocument doc;
    doc.trunnion = TRUNNION_VERSION;
    doc.job_json = job_to_json(job);
    return doc;
}

Result<Plan> interrupted(PlanDocument doc) {
    doc.interrupted = true;
    doc.valid.assign(doc.size(), 0);
    doc.why.assign(doc.size(), "not checked: the run was interrupted");
    Plan plan;
    plan.document = std::move(doc);
    plan.summary = "INTERRUPTED: poses were placed but not checked\n";
    return plan;
}

}  // namespace

Result<Plan> plan(const Job& job, const PlanOptions& options, const Control& control) {
    Stopwatch watch;
    watch.stage("part");
    auto setup = set_up(job, control);
    if (!setup) return fail_up(std::move(setup));
    const Setup& s = *setup;
    if (control.cancelled()) return fail_cancelled("reading the part");

    PlanDocument doc = blank_document(job);
    // The contact path keeps the chord tolerance. Where the cutter, which turns on the way, still cuts deeper between two poses,
    // the steps are made shorter and everything is made anew.
    constexpr int kRounds = 5;
    Steps steps;
    std::optional<Poses> poses;
    std::optional<CheckedPath> checked;
    for (int round = 1;; ++round) {
        auto made = make_poses(job, s, steps, watch, control);
        if (!made) return fail_up(std::move(made));
        poses = std::move(*made);
        watch.stage("check");
        CheckOptions check = s.check;
        check.refused = poses->refused;
        auto result = check_path(poses->path, s.cutter, s.scene, check, control, contact_points(poses->path, poses->contacts));
        if (!result) {
            if (result.error().code != ErrorCode::cancelled) return fail_up(std::move(result));
            fill_poses(doc, poses->path, poses->contacts);
            return interrupted(std::move(doc));
        }
        checked = std::move(*result);
        // Given points, and those of another system's path, stay as they are: nothing may be put between them.
        const bool given = std::holds_alternative<GivenPoints>(job.pattern) || !job.cldata_file.empty();
        if (round == kRounds || given || !chords_fail(*checked, s.check)) break;
        steps.chord *= 0.5;
        steps.angle *= 0.7;
        control.say(fmt::format("between poses the cutter goes deeper than allowed: again with chord {:.4g} mm, {:.3g} deg",
                                steps.chord * job.tolerance.chord, steps.angle * degrees(job.tolerance.angle)));
    }
    if (steps.chord < 1.0)
        doc.warnings.push_back(
            fmt::format("steps were shortened to a chord of {:.4g} mm so that the moves between poses stay within tolerance",
                        steps.chord * job.tolerance.chord));

    watch.stage("machine");
    const auto check = [&](const PosePath& path) {
        return check_path(path, s.cutter, s.scene, s.check, control, contact_points(path, poses->contacts));
    };
    auto moved = follow(std::move(*checked), s, check, control);
    if (!moved) {
        if (moved.error().code != ErrorCode::cancelled) return fail_up(std::move(moved));
        fill_poses(doc, poses->path, poses->contacts);
        return interrupted(std::move(doc));
    }
    poses->path = moved->poses();
    fill_poses(doc, poses->path, poses->contacts);
    fill_strip(doc, s, job.tolerance.scallop);
    fill_positions(doc, *poses);
    fill_checks(doc, moved->checked());
    fill_machine(doc, *moved);
    for (const std::string& w : poses->notes) doc.warnings.push_back(fmt::format("orientation: {}", w));
    for (const std::string& w : moved->warnings()) doc.warnings.push_back(w);
    for (const std::string& p : s.part->problems) doc.warnings.push_back("part: " + p);
    ordered_json metrics = metrics_of(poses->contacts, poses->path, *moved, s);
    add_axis_measures(metrics, poses->contacts, *moved, job.feed);
    add_axis_curves(doc, poses->contacts, poses->path, s, job.tolerance.scallop);
    double strip = 0.0, strips = 0.0, least_strip = std::numeric_limits<double>::infinity();
    for (const double w : doc.strip_width_mm)
        if (std::isfinite(w)) strip += w, strips += 1.0, least_strip = std::min(least_strip, w);
    if (strips > 0.0) {
        metrics["strip_width_mean_mm"] = strip / strips;
        metrics["strip_width_least_mm"] = least_strip;
    }
    for (const auto& [name, json] : poses->measured) metrics[name] = ordered_json::parse(json);
    if (job.outcome == Outcome::trim) metrics["trimmed_contacts"] = poses->outcome.trimmed;
    if (job.outcome == Outcome::retract) {
        metrics["retracted_contacts"] = poses->outcome.retracted;
        metrics["greatest_retract_mm"] = poses->outcome.greatest_retract;
    }
    if (const auto timing = time_motion(*moved, {}, control)) add_timing(metrics, doc, *timing, *moved);
    doc.metrics_json = metrics.dump();

    Plan plan;
    plan.valid = moved->valid();
    plan.program_name = "program." + file_ending(job.dialect);
    watch.stage("program");
    if (plan.valid || options.allow_invalid) {
        ProgramOptions program = s.program;
        program.allow_invalid = options.allow_invalid;
        auto text = proved_program(*moved, program, doc);
        if (!text) return fail_up(std::move(text));
        plan.program = std::move(*text);
        program.dialect = "apt";
        program.plane = false;  // CLDATA holds tips and axes in any case
        auto cls = proved_program(*moved, program, doc);
        if (!cls) return fail_up(std::move(cls));
        plan.cls = std::move(*cls);
    }
    watch.stage("report");
    plan.summary = summary_of(doc, *moved, job, s, metrics);
    if (options.report) {
        ReportInput input;
        input.plan = &doc;
        input.part = s.part.get();
        input.machined_faces = s.faces;
        for (const CheckBody& body : s.bodies) input.check_bodies.push_back({body.name, &body.part->mesh});
        input.tool = outline_of(s.cutter);
        input.title = std::filesystem::path(s.part->file).filename().string();
        plan.report_html = report_html(input);
    }
    watch.stop();
    doc.timings_s = watch.times();
    plan.document = std::move(doc);
    return plan;
}

Result<std::vector<std::filesystem::path>> write_plan(const Plan& plan, const std::filesystem::path& folder) {
    if (auto ready = prepare_folder(folder); !ready) return fail_up(std::move(ready));
    std::vector<std::filesystem::path> written;
    std::vector<FileToWrite> files;
    const auto add = [&](const std::string& name, std::string_view content) {
        written.push_back(folder / name);
        files.push_back({folder / name, content});
    };
    const std::string json = plan_to_json(plan.document);
    std::vector<std::filesystem::path> outdated;
    if (plan.document.interrupted) {
        add("plan.partial.json", json);
    } else {
        if (!plan.report_html.empty()) add("report.html", plan.report_html);
        if (!plan.cls.empty()) add("path.cls", plan.cls);
        if (!plan.program.empty()) add(plan.program_name, plan.program);
        add("plan.json", json);
        for (const std::string& dialect : dialect_names())
            outdated.push_back(folder / (dialect == "apt" ? "path.cls" : "program." + file_ending(dialect)));
        outdated.push_back(folder / "report.html");
        outdated.push_back(folder / "plan.partial.json");
        std::erase_if(outdated, [&](const auto& path) {
            return std::find(written.begin(), written.end(), path) != written.end() || !std::filesystem::exists(path);
        });
    }
    if (auto done = write_files_atomically(files, outdated); !done) return fail_up(std::move(done));
    return written;
}

}  // namespace trunnion
