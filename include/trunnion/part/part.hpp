// A part: faces with trimmed surfaces, and one triangulation of everything for checking and for showing.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/control.hpp"
#include "trunnion/part/surface.hpp"

namespace trunnion {

/// The trimming loops of a face as polygons in (u, v), closed implicitly, inside by the even-odd rule. No loops = the
/// whole domain. The polygons follow the true trimming curves to `chord_error` mm in space. The border counts as inside where
/// it runs along u or v, so that an iso-parametric line on the edge of a rectangular face is not lost.
class Trim {
public:
    Trim() = default;
    explicit Trim(std::vector<std::vector<Vec2>> loops, double chord_error = 0.0);

    bool whole_domain() const { return loops_.empty(); }
    const std::vector<std::vector<Vec2>>& loops() const { return loops_; }
    double chord_error() const { return chord_error_; }
    bool contains(const Vec2& uv) const;
    /// Inside intervals of v on the line u = value (along_u = false) or of u on the line v = value (along_u = true),
    /// ascending, clipped to `range`.
    std::vector<Interval> inside(bool along_u, double value, const Interval& range) const;

    struct Index;  // loop edges in rows of u and of v; defined in src/part

private:
    std::vector<std::vector<Vec2>> loops_;
    double chord_error_ = 0.0;
    std::shared_ptr<const Index> index_;
};

struct Face {
    int index = 0;                   ///< as `info` numbers them, from 0
    std::string kind;                ///< "bspline", "plane", "cylinder", ... as the file says; "mesh" without a surface
    std::optional<Surface> surface;  ///< outward normal already right for the face's orientation
    Trim trim;
    double area = 0.0;  ///< mm2
    Box3 box;
    std::vector<std::string> problems;
};

/// Triangles, counter-clockwise seen from outside. Vertices are shared between triangles and between faces where the
/// model's edges are shared.
struct Mesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> face;      ///< per triangle: index into Part::faces
    std::vector<std::array<Vec2, 3>> uv;  ///< per triangle: its corners on its face's surface; empty for STL and OBJ
    std::vector<double> deviation;        ///< per triangle: rigorous bound, mm, between the flat triangle and the
                                          ///< surface over its (u, v) triangle; empty for STL and OBJ (exact)
    double chord_error = 0.0;             ///< mm, greatest of `deviation` and of the trimming polygons' error
};

struct Part {
    std::string file;  ///< as given; "(job)" for a surface given in the job
    std::string unit;  ///< of the file: "mm", "inch", "m"...; geometry here is always mm. STL and OBJ: "mm" (assumed)
    std::vector<Face> faces;
    Mesh mesh;
    Box3 box;
    bool closed = false;  ///< the mesh bounds a volume: every edge has two triangles of opposite sense
    std::vector<std::string> problems;
};

struct LoadOptions {
    double chord = 0.01;  ///< mm, wanted between triangles and surfaces
    double angle = 0.35;  ///< rad, greatest turn of the normal across a triangle edge, for showing
};

/// Reads .step .stp .iges .igs .brep .stl .obj (by ending, any case).
/// Error: not_found; unreadable (truncated, empty, no faces, NaN: says which line, triangle or entity);
/// unsupported (unknown ending, a STEP file that holds only tessellated faces).
Result<Part> load_part(const std::filesystem::path& file, const LoadOptions& options, const Control& control);

/// A part of one face from a surface given in the job; the face is the whole domain of `surface`.
/// With `whole` given, the rest of that surface (the face is a patch of it) is a second face that is only checked.
Result<Part> part_from_surface(const Surface& surface, const std::optional<Surface>& whole, const LoadOptions& options);

/// What `trunnion info` prints, as JSON text (design, section 4) and as a table for people.
std::string info_json(const Part& part);
std::string info_table(const Part& part);

/// Curvature range of a face (1/mm, concave positive), sampled on a grid inside its trim. Zeroes without a surface.
struct CurvatureRange {
    double least = 0.0, greatest = 0.0;
};
CurvatureRange curvature_range(const Face& face, int samples_per_side = 24);

/// Whether every edge of the mesh has exactly two triangles of opposite sense.
bool is_closed(const Mesh& mesh);

}  // namespace trunnion
