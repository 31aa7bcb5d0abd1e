// plan.json: everything a plan found, as data that is read and written without loss.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/base/vec.hpp"

namespace trunnion {

inline constexpr int kPlanSchema = 1;

struct PlanPass {
    std::size_t first = 0, count = 0;
    std::string kind;  ///< "cut", "lead-in", "lead-out", "link"
};

struct PlanCheck {
    std::string what, bound, engine;
    bool holds = true;
};

/// The document. Pose and machine arrays all have N entries or none (cl and axis always N); absent values are NaN and
/// written as null, infinities as "inf" and "-inf". Passes, where there are any, cover the poses in order without gaps.
/// Schema: design, section 5.
struct PlanDocument {
    std::string trunnion;  ///< version
    int schema = kPlanSchema;
    std::string job_json;  ///< the resolved job, every default filled in: JSON text of an object
    std::vector<PlanPass> passes;

    // poses (parallel arrays)
    std::vector<Vec3> cc, normal, feed, cl, axis, second_contact;
    std::vector<Vec2> uv;
    std::vector<Vec2> safe_tilt_deg;  ///< positioning methods: every tilt about the insert between the two is clear
    std::vector<std::string> status;  ///< positioning methods: how each position ended, "" on links
    std::vector<std::int32_t> face;   ///< face of the contact, -1 on links
    std::vector<double> lead_deg, tilt_deg, gouge_mm, motion_gouge_mm, clearance_mm, strip_width_mm;
    std::vector<std::uint8_t> valid, given;  ///< given: the contact was a point of the job (flag `given`)
    std::vector<std::string> why;
    /// Further per-pose numbers that a method adds ("tilt_about_insert_deg", ...), each N entries.
    std::map<std::string, std::vector<double>> extra;

    // machine
    std::string machine_name;
    std::vector<std::string> axes;                 ///< letters, e.g. X Y Z A C
    std::vector<std::array<double, 5>> positions;  ///< mm and degrees
    std::vector<double> time_s, feed_mm_min;
    std::vector<std::uint8_t> branch;

    std::string metrics_json = "{}";  ///< JSON object text; names carry units
    std::vector<PlanCheck> checks;
    std::map<std::string, double> timings_s;
    std::vector<std::string> warnings;
    bool interrupted = false;  ///< a partial result kept after an interruption

    std::size_t size() const { return cl.size(); }
};

/// Shortest decimal text that reads back to the same doubles (17 significant digits at most). Bytes of texts that are not
/// UTF-8 become U+FFFD; all else comes back bit for bit, and writing what was read gives the same bytes.
/// Requires: the lengths and passes as above, no `extra` named like another array, job and metrics JSON objects.
std::string plan_to_json(const PlanDocument& plan);
/// Error: unreadable with the byte offset or the key and index: not JSON, wrong schema, unknown or repeated key, arrays of
/// unequal length, passes that do not cover the poses, an axis that is not of unit length to 1e-6. unsupported from 4 GiB on.
Result<PlanDocument> plan_from_json(std::string_view text);

}  // namespace trunnion
