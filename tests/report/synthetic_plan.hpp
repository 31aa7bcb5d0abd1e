// A job made up for the tests and the benchmark of the report: a wavy block in a vise, a bull cutter with shank and holder
// on zigzag passes, with lead-in, links and an A-C machine's angles. Looks like the real thing; nothing here is checked.
#pragma once

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "trunnion/report/html.hpp"

namespace trunnion::synthetic {

struct Options {
    int passes = 24, poses_per_pass = 90;
    int grid = 90;                             ///< squares per side of the wavy face
    std::size_t bad_first = 0, bad_count = 0;  ///< poses marked not valid
};

inline double height(double x, double y) {
    return 34 + 7 * std::sin(x / 19.0) * std::cos(y / 15.0) + 4 * std::sin((x + y) / 31.0);
}
inline Vec3 normal(double x, double y) {
    constexpr double h = 1e-4;
    return Vec3(-(height(x + h, y) - height(x - h, y)) / (2 * h), -(height(x, y + h) - height(x, y - h)) / (2 * h), 1)
        .normalized();
}

inline void add_box(Mesh& mesh, const Vec3& lo, const Vec3& hi, std::uint32_t face) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 8; ++k)
        mesh.vertices.emplace_back(k & 1 ? hi.x() : lo.x(), k & 2 ? hi.y() : lo.y(), k & 4 ? hi.z() : lo.z());
    for (const auto& [a, b, c, d] : std::vector<std::array<std::uint32_t, 4>>{
             {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
        mesh.triangles.push_back({first + a, first + b, first + c});
        mesh.triangles.push_back({first + a, first + c, first + d});
        mesh.face.insert(mesh.face.end(), 2, face++);
    }
}

/// 120 x 80 mm, wavy top (face 0), flat sides (1..4) and bottom (5); vertices shared along the edges.
inline Part wavy_block(int grid) {
    Part part;
    part.file = "wavy-block.step";
    part.unit = "mm";
    Mesh& mesh = part.mesh;
    const auto n = static_cast<std::uint32_t>(grid);
    const auto top = [&](std::uint32_t i, std::uint32_t j) { return j * (n + 1) + i; };
    const auto foot = [&](std::uint32_t i, std::uint32_t j) { return (n + 1) * (n + 1) + top(i, j); };
    for (const bool at_foot : {false, true})
        for (std::uint32_t j = 0; j <= n; ++j)
            for (std::uint32_t i = 0; i <= n; ++i) {
                const double x = 120.0 * i / n, y = 80.0 * j / n;
                mesh.vertices.emplace_back(x, y, at_foot ? 0.0 : height(x, y));
            }
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d, std::uint32_t face) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
        mesh.face.insert(mesh.face.end(), 2, face);
    };
    for (std::uint32_t j = 0; j < n; ++j)
        for (std::uint32_t i = 0; i < n; ++i) {
            quad(top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1), 0);
            quad(foot(i, j), foot(i, j + 1), foot(i + 1, j + 1), foot(i + 1, j), 5);
        }
    for (std::uint32_t i = 0; i < n; ++i) {
        quad(foot(i, 0), foot(i + 1, 0), top(i + 1, 0), top(i, 0), 1);
        quad(foot(i + 1, n), foot(i, n), top(i, n), top(i + 1, n), 2);
        quad(foot(0, i + 1), foot(0, i), top(0, i), top(0, i + 1), 3);
        quad(foot(n, i), foot(n, i + 1), top(n, i + 1), top(n, i), 4);
    }
    for (const Vec3& p : mesh.vertices) part.box.add(p);
    for (int face = 0; face < 6; ++face) {
        Face entry;
        entry.index = face;
        entry.kind = face == 0 ? "bspline" : "plane";
        part.faces.push_back(entry);
    }
    part.closed = true;
    return part;
}

inline Mesh vise() {
    Mesh mesh;
    add_box(mesh, {-8, -26, -18}, {128, -1, 16}, 0);
    add_box(mesh, {-8, 81, -18}, {128, 106, 16}, 6);
    add_box(mesh, {-14, -26, -32}, {134, 106, -18}, 12);
    return mesh;
}

/// Bull cutter, diameter 16, corner 3, with shank and a holder of two cones.
inline ToolOutline tool() {
    ToolOutline outline;
    std::vector<Vec2> cutter{{0, 0}, {5, 0}};
    for (int k = 1; k <= 8; ++k) cutter.emplace_back(5 + 3 * std::sin(k * kPi / 16), 3 - 3 * std::cos(k * kPi / 16));
    cutter.emplace_back(8, 26);
    cutter.emplace_back(0, 26);
    outline.pieces = {{"cutter", cutter},
                      {"shank", {{0, 26}, {7.5, 26}, {7.5, 52}, {0, 52}}},
                      {"holder 1", {{0, 52}, {14, 52}, {17, 70}, {0, 70}}},
                      {"holder 2", {{0, 70}, {24, 70}, {24, 88}, {0, 88}}}};
    return outline;
}

inline PlanDocument plan(const Options& options) {
    PlanDocument plan;
    plan.trunnion = "0.1.0";
    plan.job_json =
        R"({"part": {"file": "wavy-block.step", "faces": [0]}, "cutter": {"shape": "bull", "diameter_mm": 16, "corner_mm": 3, "flute_mm": 26,
 "shank": {"diameter_mm": 15, "length_mm": 26}, "holder": [{"bottom_mm": 28}, {"bottom_mm": 48}], "clearance_mm": 1.0}, "path": {"pattern": "isoparametric", "along": "u"},
 "orientation": {"method": "sturz", "lead_deg": 0, "tilt_deg": 12}, "machine": {"name": "ac-table-table", "feed_mm_min": 1500},
 "tolerance": {"chord_mm": 0.01, "gouge_mm": 0.001, "scallop_mm": 0.02, "angle_deg": 1}})";
    const double r = 3, R_major = 5, nan = std::nan("");
    const auto add = [&](const Vec3& cl, const Vec3& axis, const Vec3& cc, const Vec3& n, const Vec3& f, const Vec2& uv,
                         double lead, double tilt, double feed) {
        plan.cl.push_back(cl);
        plan.axis.push_back(axis.normalized());
        plan.cc.push_back(cc);
        plan.normal.push_back(n);
        plan.feed.push_back(f);
        plan.uv.push_back(uv);
        plan.face.push_back(std::isnan(lead) ? -1 : 0);
        plan.lead_deg.push_back(lead);
        plan.tilt_deg.push_back(tilt);
        plan.gouge_mm.push_back(std::isnan(lead) ? nan : 4e-4 * (1 + std::sin(cc.x() / 7)));
        plan.motion_gouge_mm.push_back(std::isnan(lead) ? nan : 6e-4);
        plan.clearance_mm.push_back(5 + 3 * std::cos(cl.x() / 20));
        plan.feed_mm_min.push_back(feed);
    };
    const Vec3 none = Vec3::Constant(nan);
    const auto air = [&](const Vec3& cl, const Vec3& axis, double feed) {
        add(cl, axis, none, none, none, {nan, nan}, nan, nan, feed);
    };
    for (int p = 0; p < options.passes; ++p) {
        const double y = 80.0 * (p + 0.5) / options.passes;
        for (int i = 0; i < options.poses_per_pass; ++i) {
            const double t = (i + 0.5) / options.poses_per_pass, x = 120.0 * (p % 2 == 0 ? t : 1 - t), way = p % 2 == 0 ? 1 : -1;
            const Vec3 n = normal(x, y), across = n.cross(Vec3(way, 0, 0)).normalized(), f = across.cross(n),
                       cc(x, y, height(x, y));
            const double tilt = radians(-12 * way);  // always towards the operator
            const Vec3 T = std::cos(tilt) * n + std::sin(tilt) * n.cross(f), q = (n - n.dot(T) * T).normalized();
            const Vec3 cl = cc + r * n + R_major * q - r * T;
            if (i == 0) {
                for (int k = 3; k >= 1; --k) air(cl + (k * 5.0) * T, T, 800);
                plan.passes.push_back({plan.size() - 3, 3, "lead-in"});
            }
            add(cl, T, cc, n, f, {x / 120, y / 80}, 0, degrees(tilt), 1500 - 400 * std::pow(std::sin(x / 19.0), 2));
        }
        plan.passes.push_back({plan.size() - static_cast<std::size_t>(options.poses_per_pass),
                               static_cast<std::size_t>(options.poses_per_pass), "cut"});
        const Vec3 end = plan.cl.back(), axis = plan.axis.back();
        for (int k = 1; k <= 3; ++k) air(end + (k * 5.0) * axis, axis, 800);
        plan.passes.push_back({plan.size() - 3, 3, "lead-out"});
        if (p + 1 < options.passes) {
            const Vec3 from = plan.cl.back();
            for (int k = 1; k <= 6; ++k)
                air(from + Vec3(0, k * 80.0 / options.passes / 6, 22 * std::sin(k * kPi / 6)), axis, 6000);
            plan.passes.push_back({plan.size() - 6, 6, "link"});
        }
    }
    plan.valid.assign(plan.size(), 1);
    plan.given.assign(plan.size(), 0);
    plan.why.assign(plan.size(), "");
    for (std::size_t i = options.bad_first; i < options.bad_first + options.bad_count && i < plan.size(); ++i) {
        plan.valid[i] = 0;
        plan.why[i] = "holder 1 comes 0.42 mm into vise.stl at (-8.0, 44.1, 16.0)";
    }
    plan.machine_name = "ac-table-table";
    plan.axes = {"X", "Y", "Z", "A", "C"};
    double c_before = 0, time = 0;
    for (std::size_t i = 0; i < plan.size(); ++i) {
        const Vec3& T = plan.axis[i];
        double c = degrees(std::atan2(T.x(), -T.y()));
        while (c - c_before > 180) c -= 360;
        while (c - c_before < -180) c += 360;
        c_before = c;
        plan.positions.push_back({plan.cl[i].x(), plan.cl[i].y(), plan.cl[i].z(), degrees(std::acos(T.z())), c});
        if (i > 0) time += std::max((plan.cl[i] - plan.cl[i - 1]).norm() / plan.feed_mm_min[i] * 60, 0.004);
        plan.time_s.push_back(time);
    }
    plan.branch.assign(plan.size(), 0);
    plan.metrics_json = R"({"delta_t_deg": 0.214, "strip_width_mean_mm": 2.81, "poses_near_singular": 41})";
    const bool bad = options.bad_count > 0;
    plan.checks = {{"gouge of the cutter at the poses", "<= 0.001 mm on the exact surfaces", "convex tree, certified", true},
                   {"gouge of the cutter between the poses", "<= 0.001 mm along every motion", "convex tree, certified", true},
                   {"shank and holder", ">= 1 mm from part and check bodies", "convex tree, certified", !bad},
                   {"axis travel", "inside the limits of ac-table-table", "joint positions of every pose", true}};
    plan.timings_s = {{"check", 0.412}, {"orientation", 0.021}, {"part", 0.35}, {"path", 0.048}};
    plan.warnings = {"41 poses are within 2 deg of the singularity of A and C; the rotary axes turn fast there"};
    return plan;
}

}  // namespace trunnion::synthetic
