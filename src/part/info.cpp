// What `trunnion info` says about a part.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/part/part.hpp"

namespace trunnion {

namespace {

nlohmann::json json_of(const Box3& box) {
    if (box.empty()) return nullptr;
    return {{box.lo.x(), box.lo.y(), box.lo.z()}, {box.hi.x(), box.hi.y(), box.hi.z()}};
}

double area_of(const Part& part) {
    double area = 0.0;
    for (const Face& face : part.faces) area += face.area;
    return area;
}

std::string box_text(const Box3& box) {
    if (box.empty()) return "-";
    return fmt::format("{:.5g} {:.5g} {:.5g} .. {:.5g} {:.5g} {:.5g}", box.lo.x(), box.lo.y(), box.lo.z(), box.hi.x(), box.hi.y(),
                       box.hi.z());
}

}  // namespace

std::string info_json(const Part& part) {
    nlohmann::ordered_json all;
    all["file"] = part.file;
    all["unit"] = part.unit;
    all["closed"] = part.closed;
    all["area_mm2"] = area_of(part);
    all["box_mm"] = json_of(part.box);
    all["triangles"] = part.mesh.triangles.size();
    all["chord_error_mm"] = part.mesh.chord_error;
    all["faces"] = nlohmann::ordered_json::array();
    for (const Face& face : part.faces) {
        nlohmann::ordered_json one;
        one["index"] = face.index;
        one["kind"] = face.kind;
        one["area_mm2"] = face.area;
        one["box_mm"] = json_of(face.box);
        if (face.surface) {
            const Domain& d = face.surface->domain();
            const CurvatureRange range = curvature_range(face);
            one["uv_range"] = {d.u.lo, d.u.hi, d.v.lo, d.v.hi};
            one["curvature_range_per_mm"] = {range.least, range.greatest};
        } else {
            one["uv_range"] = nullptr;
            one["curvature_range_per_mm"] = nullptr;
        }
        one["problems"] = face.problems;
        all["faces"].push_back(std::move(one));
    }
    all["problems"] = part.problems;
    return all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string info_table(const Part& part) {
    std::string text = fmt::format("{}: {} faces, unit {}, {}, area {:.6g} mm2, box {} mm\nmesh: {} triangles within {:.3g} mm\n",
                                   part.file, part.faces.size(), part.unit, part.closed ? "closed" : "open", area_of(part),
                                   box_text(part.box), part.mesh.triangles.size(), part.mesh.chord_error);
    text += fmt::format("{:>5}  {:<10} {:>12}  {:<52} {:<23} {}\n", "face", "kind", "area mm2", "box mm", "curvature 1/mm",
                        "u, v range");
    for (const Face& face : part.faces) {
        std::string curvature = "-", range = "-";
        if (face.surface) {
            const CurvatureRange c = curvature_range(face);
            const Domain& d = face.surface->domain();
            curvature = fmt::format("{:.4g} .. {:.4g}", c.least, c.greatest);
            range = fmt::format("{:.5g} .. {:.5g}, {:.5g} .. {:.5g}", d.u.lo, d.u.hi, d.v.lo, d.v.hi);
        }
        text += fmt::format("{:>5}  {:<10} {:>12.6g}  {:<52} {:<23} {}\n", face.index, face.kind, face.area, box_text(face.box),
                            curvature, range);
        for (const std::string& problem : face.problems) text += fmt::format("       ! {}\n", problem);
    }
    for (const std::string& problem : part.problems) text += fmt::format("! {}\n", problem);
    return text;
}

}  // namespace trunnion
