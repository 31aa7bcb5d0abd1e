// A job: everything a user says, as read from a TOML file (docs/jobs.md), defaults filled in.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/tolerance.hpp"
#include "trunnion/cutter/cutter.hpp"
#include "trunnion/orientation/axis_step.hpp"
#include "trunnion/orientation/method.hpp"
#include "trunnion/part/surface.hpp"
#include "trunnion/path/pattern.hpp"
#include "trunnion/pose/place.hpp"
#include "trunnion/pose/positioning.hpp"

namespace trunnion {

/// A surface given in the job: analytic, Bezier or B-spline, and the patch of it that is machined.
struct SurfaceSpec {
    std::optional<AnalyticData> analytic;
    std::optional<BSplineData> spline;
    std::optional<std::array<double, 4>> patch_uv;  ///< u0, u1, v0, v1
    bool flip_normal = false;
};

/// What becomes of contacts at which the whole tool is not clear.
enum class Outcome {
    fail,     ///< the plan is not valid
    trim,     ///< they are left out; the pass is split there
    retract,  ///< the tool is drawn back along its axis until it is clear
};

struct Job {
    std::string source = "(none)";  ///< the job file, for messages
    // [part]
    std::string part_file;  ///< absolute; empty with a surface
    std::optional<SurfaceSpec> surface;
    std::optional<std::vector<int>> faces;  ///< empty: the only face
    bool flip_normal = false;               ///< of the machined faces
    std::vector<std::string> check_files;   ///< absolute
    double mesh_chord = 0.01;               ///< mm, of the triangulation (part.chord_mm)
    // [cutter]
    CutterSpec cutter;
    double clearance = 1.0;  ///< mm
    // [path]
    Pattern pattern;
    // [orientation]
    Method method;
    std::vector<AxisStep> then;  ///< behind the method, in order
    Outcome outcome = Outcome::fail;
    std::optional<SurfaceSpec> guide;       ///< of `normals`: a second surface given in place
    std::optional<Multipoint> positioning;  ///< instead of `method`: contact and axis are found together
    // [links]
    std::optional<ClearanceSurface> clearance_surface;  ///< empty: chosen from the part and the axes
    double lead = 2.0;                                  ///< mm
    bool low_links = true;                              ///< cross between passes low over the part where that is clear
    double link_margin = 10.0;                          ///< mm beyond the part and the check bodies, for the automatic surface
    // [machine]
    std::string machine_name = "ac-table-table";
    std::string machine_file;              ///< absolute; instead of a name
    double feed = 25.0, lead_feed = 12.5;  ///< mm/s
    std::optional<Vec3> work_offset;       ///< mm, overrides the machine file's
    // [program]
    std::string dialect = "linuxcnc";  ///< or the absolute path of a dialect file
    bool plane = false;                ///< one tilted plane (3+2)
    std::optional<bool> tcp;           ///< empty: what the machine offers
    int tool_number = 1;
    double spindle_rpm = 0.0;
    // [tolerance]
    Tolerance tolerance;
};

/// `settings`: KEY=VALUE pairs that override the file ("cutter.diameter_mm=12").
/// Error: invalid_input with file, line and key, naming the nearest known key for an unknown one.
Result<Job> job_from_toml(std::string_view text, const std::filesystem::path& source,
                          const std::vector<std::string>& settings = {});
Result<Job> load_job(const std::filesystem::path& file, const std::vector<std::string>& settings = {});

/// The resolved job as JSON, every default filled in, paths absolute; job_from_json reads it back to the same job.
std::string job_to_json(const Job& job);
Result<Job> job_from_json(std::string_view text, const std::string& source);

Result<Surface> make_surface(const SurfaceSpec& spec);

}  // namespace trunnion
