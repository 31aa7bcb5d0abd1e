// report.html: one file that opens offline.
#pragma once

#include <string>
#include <vector>

#include "trunnion/part/part.hpp"
#include "trunnion/report/plan_file.hpp"

namespace trunnion {

/// Outline of the rotational tool for drawing: (radius, height above the tip), from the tip up, mm.
struct ToolOutline {
    struct Piece {
        std::string name;           ///< "cutter", "shank", "holder 1"
        std::vector<Vec2> outline;  ///< polyline, radius >= 0, heights non-decreasing
    };
    std::vector<Piece> pieces;
};

struct SceneBody {
    std::string name;
    const Mesh* mesh = nullptr;
};

struct ReportInput {
    const PlanDocument* plan = nullptr;  ///< required
    const Part* part = nullptr;          ///< none: the scene shows path and tool only
    std::vector<int> machined_faces;
    std::vector<SceneBody> check_bodies;
    ToolOutline tool;
    std::string title;
};

/// The page: summary first, then the 3-D scene (part, passes, axes, moving tool) and the rotary angles against time.
/// A plan is called valid only if every pose was judged valid, every check holds and the run was not interrupted.
/// All text from files is escaped; geometry is embedded as base64 arrays; no network at run time (forbidden by the page's
/// own content security policy). Single precision: the page is for looking, the numbers are in plan.json.
std::string report_html(const ReportInput& input);

}  // namespace trunnion
