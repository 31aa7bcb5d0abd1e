#include "report/scene_data.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>
#include <type_traits>

#include <fmt/format.h>

#include "report/facts.hpp"
#include "report/text.hpp"

namespace trunnion::report {

namespace {

/// Facets that meet at less than this are shown as one smooth surface. Meshes for showing turn by up to 20 deg per edge
/// (LoadOptions::angle); real edges of machined parts are chamfers of 30 deg and more.
const double kCreaseCosine = std::cos(radians(28.0));

struct Facet {
    Vec3 weighted;  ///< normal times twice the area
    Vec3 unit;      ///< zero for a degenerate triangle
};

std::vector<Facet> facets_of(const Mesh& mesh) {
    std::vector<Facet> facets;
    facets.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 weighted = (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
        const double size = weighted.norm();
        facets.push_back({weighted, size > 0 ? Vec3(weighted / size) : Vec3(Vec3::Zero())});
    }
    return facets;
}

/// Lines worth drawing: where two faces meet, where the surface turns sharply, and where it ends.
std::vector<std::array<std::uint32_t, 2>> feature_edges(const Mesh& mesh, const std::vector<Facet>& facets) {
    struct Side {
        std::uint32_t a, b, triangle;
        bool same_edge(const Side& other) const { return a == other.a && b == other.b; }
    };
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
            sides.push_back({a, b, t});
        }
    std::ranges::sort(
        sides, [](const Side& x, const Side& y) { return std::tie(x.a, x.b, x.triangle) < std::tie(y.a, y.b, y.triangle); });
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].same_edge(sides[i])) ++end;
        bool feature = end - i != 2;
        if (!feature) {
            const std::uint32_t t = sides[i].triangle, s = sides[i + 1].triangle;
            const bool two_faces = !mesh.face.empty() && mesh.face[t] != mesh.face[s];
            feature = two_faces || facets[t].unit.dot(facets[s].unit) < kCreaseCosine;
        }
        if (feature) edges.push_back({sides[i].a, sides[i].b});
        i = end;
    }
    return edges;
}

/// The blocks and the JSON grow together: a block is named in the JSON by its number.
class Blocks {
public:
    template <class T>
    std::string add(const std::vector<T>& values) {
        static_assert(std::is_arithmetic_v<T>);
        const char kind = std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
        html_ += fmt::format("<script type=\"text/plain\" id=\"b{}\" data-type=\"{}{}\">{}</script>\n", count_, kind, sizeof(T),
                             base64_of(values));
        return std::to_string(count_++);
    }
    std::string take() && { return std::move(html_); }

private:
    std::string html_;
    int count_ = 0;
};

std::vector<float> floats(const std::vector<double>& values) {
    return {values.begin(), values.end()};
}
std::vector<float> floats(const std::vector<Vec3>& values, const Vec3& origin) {
    std::vector<float> all;
    all.reserve(3 * values.size());
    for (const Vec3& value : values)
        for (const double component : {value.x() - origin.x(), value.y() - origin.y(), value.z() - origin.z()})
            all.push_back(static_cast<float>(component));
    return all;
}
std::vector<float> floats(const std::vector<std::array<double, 5>>& values) {
    std::vector<float> all;
    all.reserve(5 * values.size());
    for (const auto& value : values) all.insert(all.end(), value.begin(), value.end());
    return all;
}

std::string body_json(const SceneBody& body, std::string_view role, const std::vector<int>& machined, const Vec3& origin,
                      Blocks& blocks) {
    const ShadedMesh shaded = shade(*body.mesh, origin);
    const std::set<int> machined_faces(machined.begin(), machined.end());
    std::vector<std::uint32_t> tinted, plain;
    for (std::size_t t = 0; t < body.mesh->triangles.size(); ++t) {
        const int face = body.mesh->face.empty() ? -1 : static_cast<int>(body.mesh->face[t]);
        auto& target = machined_faces.contains(face) ? tinted : plain;
        target.insert(target.end(), shaded.indices.begin() + static_cast<std::ptrdiff_t>(3 * t),
                      shaded.indices.begin() + static_cast<std::ptrdiff_t>(3 * t + 3));
    }
    return fmt::format(R"({{"name":{},"role":"{}","positions":{},"normals":{},"machined":{},"plain":{},"edges":{}}})",
                       json_string(body.name), role, blocks.add(shaded.positions), blocks.add(shaded.normals), blocks.add(tinted),
                       blocks.add(plain), blocks.add(shaded.edges));
}

std::string poses_json(const PlanDocument& plan, const Vec3& origin, Blocks& blocks) {
    std::string json = fmt::format(R"("count":{})", plan.size());
    const auto add = [&](std::string_view name, const auto& values) {
        if (!values.empty()) json += fmt::format(",\"{}\":{}", name, blocks.add(values));
    };
    add("cl", floats(plan.cl, origin));
    add("axis", floats(plan.axis, Vec3::Zero()));
    add("cc", floats(plan.cc, origin));
    add("positions", floats(plan.positions));
    add("clock", clock_of(plan).at);
    add("feed_mm_min", floats(plan.feed_mm_min));
    add("lead_deg", floats(plan.lead_deg));
    add("tilt_deg", floats(plan.tilt_deg));
    add("gouge_mm", floats(plan.gouge_mm));
    add("motion_gouge_mm", floats(plan.motion_gouge_mm));
    add("clearance_mm", floats(plan.clearance_mm));
    add("strip_width_mm", floats(plan.strip_width_mm));
    add("valid", plan.valid);
    // What a method or the measures add, under names of their own.
    for (const auto& [name, values] : plan.extra)
        if (std::ranges::all_of(name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }))
            add("extra:" + name, floats(values));
    return '{' + json + '}';
}

template <class T, class Text>
std::string list(const std::vector<T>& items, Text&& text) {
    std::string all = "[";
    for (const T& item : items) {
        if (all.size() > 1) all += ',';
        all += text(item);
    }
    return all + ']';
}

std::string point_json(const Vec3& p) {
    return fmt::format("[{},{},{}]", std::string_view(json_number(p.x())), std::string_view(json_number(p.y())),
                       std::string_view(json_number(p.z())));
}

}  // namespace

ShadedMesh shade(const Mesh& mesh, const Vec3& origin) {
    const std::vector<Facet> facets = facets_of(mesh);
    // Corners (3 t + k) by vertex: a counting sort.
    std::vector<std::size_t> begin(mesh.vertices.size() + 1, 0);
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) ++begin[v + 1];
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    std::vector<std::uint32_t> corners(3 * mesh.triangles.size());
    std::vector<std::size_t> fill(begin.begin(), begin.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t k = 0; k < 3; ++k) corners[fill[mesh.triangles[t][k]]++] = 3 * t + k;

    ShadedMesh shaded;
    shaded.indices.resize(3 * mesh.triangles.size());
    std::vector<std::uint32_t> first_copy(mesh.vertices.size(), 0);
    std::vector<Vec3> sums;  // one per copy of the vertex: its facets' normals, weighted by area
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        sums.clear();
        first_copy[v] = static_cast<std::uint32_t>(shaded.positions.size() / 3);
        for (std::size_t i = begin[v]; i < begin[v + 1]; ++i) {
            const Facet& facet = facets[corners[i] / 3];
            const bool degenerate = facet.unit.isZero(0);
            const auto fits = [&](const Vec3& sum) { return degenerate || sum.dot(facet.unit) >= kCreaseCosine * sum.norm(); };
            const auto copy = std::ranges::find_if(sums, fits);
            shaded.indices[corners[i]] = first_copy[v] + static_cast<std::uint32_t>(copy - sums.begin());
            if (copy == sums.end())
                sums.push_back(facet.weighted);
            else
                *copy += facet.weighted;
        }
        for (const Vec3& sum : sums) {
            const double length = sum.norm();
            const Vec3 normal = length > 0 ? Vec3(sum / length) : Vec3(Vec3::UnitZ());
            for (Eigen::Index k = 0; k < 3; ++k) {
                shaded.positions.push_back(static_cast<float>(mesh.vertices[v][k] - origin[k]));
                shaded.normals.push_back(static_cast<std::int16_t>(std::lround(32767.0 * normal[k])));
            }
        }
    }
    for (const auto& [a, b] : feature_edges(mesh, facets))
        shaded.edges.insert(shaded.edges.end(), {first_copy[a], first_copy[b]});
    return shaded;
}

std::string scene_html(const ReportInput& input) {
    const PlanDocument& plan = *input.plan;
    // Single precision is enough near the middle of what is shown, not at the far end of a large machine table.
    Box3 box;
    if (input.part)
        for (const Vec3& p : input.part->mesh.vertices) box.add(p);
    if (box.empty())
        for (const Vec3& p : plan.cl)
            if (p.allFinite()) box.add(p);
    if (box.empty()) box.add(Vec3(Vec3::Zero()));
    const Vec3 origin = box.centre();

    Blocks blocks;
    std::vector<std::string> bodies;
    if (input.part)
        bodies.push_back(body_json({input.part->file, &input.part->mesh}, "part", input.machined_faces, origin, blocks));
    for (const SceneBody& body : input.check_bodies)
        if (body.mesh) bodies.push_back(body_json(body, "check", {}, origin, blocks));

    const std::string json = fmt::format(
        R"({{"origin":{},"half":{},"clock_is_time":{},"axes":{},"passes":{},"problems":{},"tool":{},"bodies":{},"poses":{}}})",
        point_json(origin), point_json(box.half()), clock_of(plan).is_time,
        list(plan.axes, [](const std::string& letter) { return json_string(letter); }),
        list(plan.passes,
             [](const PlanPass& pass) { return fmt::format("[{},{},{}]", pass.first, pass.count, json_string(pass.kind)); }),
        list(bad_runs(plan),
             [](const BadRun& run) { return fmt::format("[{},{},{}]", run.first, run.count, json_string(run.why)); }),
        list(input.tool.pieces,
             [](const ToolOutline::Piece& piece) {
                 return fmt::format(R"({{"name":{},"outline":{}}})", json_string(piece.name),
                                    list(piece.outline, [](const Vec2& p) {
                                        return fmt::format("[{},{}]", std::string_view(json_number(p.x())),
                                                           std::string_view(json_number(p.y())));
                                    }));
             }),
        list(bodies, [](const std::string& body) { return body; }), poses_json(plan, origin, blocks));
    return "<script type=\"application/json\" id=\"report\">" + json_for_html(json) + "</script>\n" + std::move(blocks).take();
}

}  // namespace trunnion::report
