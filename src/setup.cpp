#include "setup.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace trunnion {

namespace {

Result<Part> load_subject(const Job& job, const LoadOptions& options, const Control& control) {
    if (!job.surface) return load_part(job.part_file, options, control);
    auto whole = make_surface(*job.surface);
    if (!whole) return fail_in(std::move(whole), "part.surface");
    if (!job.surface->patch_uv) return part_from_surface(*whole, std::nullopt, options);
    const auto& p = *job.surface->patch_uv;
    auto patch = whole->restricted({p[0], p[1]}, {p[2], p[3]});
    if (!patch) return fail_in(std::move(patch), "part.surface.patch_uv");
    return part_from_surface(*patch, *whole, options);
}

Result<std::vector<int>> faces_to_machine(const Job& job, const Part& part) {
    if (!job.faces) {
        if (part.faces.size() == 1 || job.surface) return std::vector<int>{0};
        return fail(ErrorCode::invalid_input,
                    fmt::format("{}: part.faces is missing and {} has {} faces; name those to machine (see `trunnion info`)",
                                job.source, part.file, part.faces.size()));
    }
    for (const int f : *job.faces)
        if (f < 0 || static_cast<std::size_t>(f) >= part.faces.size())
            return fail(ErrorCode::invalid_input,
                        fmt::format("{}: part.faces names face {}, but {} has faces 0 to {} (see `trunnion info`)", job.source, f,
                                    part.file, part.faces.size() - 1));
    return *job.faces;
}

/// Turns the outward normal of the machined faces, surfaces and triangles alike.
void flip(Part& part, const std::vector<int>& faces) {
    std::vector<bool> turned(part.faces.size(), false);
    for (const int f : faces) {
        Face& face = part.faces[static_cast<std::size_t>(f)];
        turned[static_cast<std::size_t>(f)] = true;
        if (face.surface) face.surface = face.surface->flipped();
    }
    for (std::size_t t = 0; t < part.mesh.triangles.size(); ++t) {
        if (!turned[part.mesh.face[t]]) continue;
        std::swap(part.mesh.triangles[t][1], part.mesh.triangles[t][2]);
        if (!part.mesh.uv.empty()) std::swap(part.mesh.uv[t][1], part.mesh.uv[t][2]);
    }
    part.closed = is_closed(part.mesh);
}

}  // namespace

Result<Setup> set_up(const Job& job, const Control& control) {
    auto cutter = Cutter::from(job.cutter);
    if (!cutter) return fail_in(std::move(cutter), job.source);
    auto machine = job.machine_file.empty() ? built_in_machine(job.machine_name) : load_machine(job.machine_file);
    if (!machine)
        return job.machine_file.empty() ? fail_in(std::move(machine), job.source + ": machine.name")
                                        : fail_up(std::move(machine));
    if (job.work_offset) machine->work_offset = *job.work_offset;

    const LoadOptions load{.chord = job.mesh_chord};
    auto part = load_subject(job, load, control);
    if (!part) return fail_up(std::move(part));
    auto faces = faces_to_machine(job, *part);
    if (!faces) return fail_up(std::move(faces));
    if (job.flip_normal) flip(*part, *faces);
    auto shared = std::make_shared<const Part>(std::move(*part));
    std::vector<CheckBody> bodies;
    for (const std::string& file : job.check_files) {
        auto body = load_part(file, load, control);
        if (!body) return fail_in(std::move(body), "part.check");
        bodies.push_back({std::filesystem::path(file).filename().string(), std::make_shared<const Part>(std::move(*body))});
    }
    control.say(fmt::format("{}: {} faces, {} triangles within {:.4g} mm", shared->file, shared->faces.size(),
                            shared->mesh.triangles.size(), shared->mesh.chord_error));
    auto scene = CheckScene::build(shared, bodies);
    if (!scene) return fail_up(std::move(scene));

    CheckOptions check;
    check.gouge = job.tolerance.gouge;
    check.chord = job.tolerance.chord;
    check.clearance = job.clearance;
    check.rapid_clearance = 0.25 * job.lead;
    check.clearance_cap = std::max(check.clearance_cap, 2.0 * job.clearance);
    MotionOptions motion;
    motion.feed = job.feed;
    motion.lead_feed = job.lead_feed;
    motion.tool_length = cutter->length();
    ProgramOptions program;
    program.dialect = job.dialect;
    program.plane = job.plane;
    program.tcp = job.tcp.value_or(machine->tcp);
    program.title = shared->file;
    motion.tcp = program.tcp;
    motion.tip_slack = job.tolerance.chord;
    program.tool_number = job.tool_number;
    program.tool_diameter = job.cutter.diameter;
    program.tool_corner = cutter->tip_corner_radius();
    program.spindle_rpm = job.spindle_rpm;
    return Setup{std::move(shared),
                 std::move(*faces),
                 std::move(bodies),
                 std::move(*cutter),
                 std::move(*scene),
                 std::move(*machine),
                 check,
                 motion,
                 program};
}

}  // namespace trunnion
