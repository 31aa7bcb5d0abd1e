// The check engine against brute force on the multipoint paper's saddle, 199 712 triangles: a bull-nose cutter with shank and
// holder, poses 1 to 5 mm above the surface (as the collision peers were measured) and in contact with the exact surface.
// Floor of one distance query: the boxes on the way down and the triangles at the bottom, some 60 profile evaluations of 20 ns.
#include <random>

#include <benchmark/benchmark.h>

#include "check/piece_bound.hpp"
#include "trunnion/base/parallel.hpp"
#include "trunnion/check/check.hpp"

namespace {

using namespace trunnion;

constexpr int kCells = 316;

Surface saddle() {
    constexpr double z[4][4] = {{80, 65, 90, 85}, {80, 85, 90, 95}, {100, 105, 95, 100}, {90, 100, 100, 85}};
    std::vector<std::vector<Vec3>> rows(4);
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) rows[static_cast<std::size_t>(i)].emplace_back(50.0 * i, 50.0 * j, z[i][j]);
    return *Surface::bezier(rows);
}

std::shared_ptr<const Part> saddle_mesh() {
    auto part = std::make_shared<Part>();
    const Surface surface = saddle();
    for (int i = 0; i <= kCells; ++i)
        for (int j = 0; j <= kCells; ++j) part->mesh.vertices.push_back(surface.point(double(i) / kCells, double(j) / kCells));
    const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * (kCells + 1) + j); };
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j) {
            part->mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            part->mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    part->faces.resize(1);
    part->mesh.face.assign(part->mesh.triangles.size(), 0);
    return part;
}

Cutter tool() {
    CutterSpec spec;
    spec.shape = CutterShape::bull;
    spec.diameter = 25.4;
    spec.corner_radius = 6.0;
    spec.flute = 40.0;
    spec.shank = {{25.4, 25.4, 20.0}};
    spec.holder = {{40.0, 50.0, 50.0}};
    return *Cutter::from(spec);
}

struct Pose {
    Vec3 tip, axis;
};

std::vector<Pose> poses_above(double least, double most) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(1.0 / 6, 5.0 / 6), lean(0.0, radians(30)), turn(0.0, 2 * kPi), gap(least, most);
    const Surface surface = saddle();
    std::vector<Pose> poses(2000);
    for (Pose& p : poses) {
        const double a = lean(random), b = turn(random);
        p.axis = {std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
        p.tip = surface.point(place(random), place(random)) + (gap(random) + 7.62) * Vec3::UnitZ() + p.axis;
    }
    return poses;
}

void tree(benchmark::State& state, double least, double most) {
    const CheckScene scene = *CheckScene::build(saddle_mesh(), {});
    const Cutter cutter = tool();
    const auto poses = poses_above(least, most);
    std::size_t i = 0;
    for (auto _ : state) {
        const Pose& p = poses[i++ % poses.size()];
        for (std::size_t k = 0; k < cutter.pieces().size(); ++k)
            benchmark::DoNotOptimize(piece_distance(scene, cutter, k, p.tip, p.axis, 1e-9, 1e3));
    }
    state.SetItemsProcessed(state.iterations());
}

void brute_force(benchmark::State& state) {
    const auto part = saddle_mesh();
    const Cutter cutter = tool();
    const auto poses = poses_above(1.0, 5.0);
    std::size_t i = 0;
    for (auto _ : state) {
        const Pose& p = poses[i++ % poses.size()];
        const ToolFrame frame = ToolFrame::at(p.tip, p.axis);
        for (const ToolPiece& piece : cutter.pieces()) {
            double least = 1e3;
            for (const auto& t : part->mesh.triangles) {
                std::array<Vec3, 3> X;
                std::array<Sample, 3> s;
                for (std::size_t k = 0; k < 3; ++k) {
                    X[k] = frame.point(part->mesh.vertices[t[k]]);
                    s[k] = sample(piece.profile, X[k]);
                }
                if (corner_bound(tangent_rows(X, s)) >= least) continue;
                least = std::min(least, triangle_minimum(piece.profile, X, s, 1e-9, least).value);
            }
            benchmark::DoNotOptimize(least);
        }
    }
    state.SetItemsProcessed(state.iterations());
}

/// A pass along the exact saddle, every pose in contact, certified to 0.1 um at the poses and to 11 um between them.
void certified_pass(benchmark::State& state) {
    const Surface surface = saddle();
    auto part = part_from_surface(surface, std::nullopt, {});
    const CheckScene scene = *CheckScene::build(std::make_shared<Part>(std::move(*part)), {});
    const Cutter cutter = tool();
    PosePath path;
    std::vector<std::optional<Vec3>> contacts;
    for (int i = 0; i < 760; ++i) {
        const double u = 0.2 + 0.6 * (i / 76) / 10.0, v = 0.1 + 0.8 * (i % 76) / 75.0;
        const SurfacePoint s = surface.at(u, v);
        const Vec3 n = *surface.normal(u, v), f = (s.Sv - s.Sv.dot(n) * n).normalized();
        const Vec3 axis = (std::cos(radians(15)) * n + std::sin(radians(15)) * f).normalized();
        path.cl.push_back(*tool_tip(cutter, s.S, n, axis));
        path.axis.push_back(axis);
        path.contact.push_back(i);
        contacts.emplace_back(s.S);
    }
    path.passes.push_back({0, path.size(), PassKind::cut, false});
    set_threads(1);
    for (auto _ : state) {
        const auto checked = check_path(path, cutter, scene, {}, {}, contacts);
        benchmark::DoNotOptimize(checked->valid());
    }
    set_threads(0);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(path.size()));
}

void tree_near(benchmark::State& state) {
    tree(state, 1.0, 5.0);
}
void tree_far(benchmark::State& state) {
    tree(state, 15.0, 30.0);
}
BENCHMARK(brute_force)->Unit(benchmark::kMicrosecond);
BENCHMARK(tree_near)->Unit(benchmark::kMicrosecond);
BENCHMARK(tree_far)->Unit(benchmark::kMicrosecond);
BENCHMARK(certified_pass)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
