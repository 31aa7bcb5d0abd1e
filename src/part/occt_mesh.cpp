#include "part/occt_mesh.hpp"

#include <numeric>

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>

#include <fmt/format.h>

namespace trunnion::detail {

namespace {

/// Which nodes are one vertex: union by smaller index, so that the result does not depend on the order of the unions.
class UnionFind {
public:
    explicit UnionFind(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(std::uint32_t a, std::uint32_t b) {
        a = root(a), b = root(b);
        if (a != b) parent_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::uint32_t> parent_;
};

/// The nodes of one edge on one face's triangulation, as indices into all nodes; a seam has two such chains on one face.
std::vector<std::vector<std::uint32_t>> chains_of(const TopoDS_Edge& edge, const TopoDS_Face& face, std::uint32_t first_node) {
    TopLoc_Location location;
    const Handle(Poly_Triangulation) triangulation = BRep_Tool::Triangulation(face, location);
    std::vector<std::vector<std::uint32_t>> chains;
    if (triangulation.IsNull()) return chains;
    const auto add = [&](const Handle(Poly_PolygonOnTriangulation) & polygon) {
        if (polygon.IsNull()) return;
        std::vector<std::uint32_t> chain;
        for (int k = 1; k <= polygon->NbNodes(); ++k)
            chain.push_back(first_node + static_cast<std::uint32_t>(polygon->Node(k)) - 1);
        chains.push_back(std::move(chain));
    };
    add(BRep_Tool::PolygonOnTriangulation(edge, triangulation, location));
    if (BRep_Tool::IsClosed(edge, face))
        add(BRep_Tool::PolygonOnTriangulation(TopoDS::Edge(edge.Reversed()), triangulation, location));
    return chains;
}

}  // namespace

Result<ShapeMesh> mesh_of(const TopoDS_Shape& shape, const TopTools_IndexedMapOfShape& faces,
                          std::span<const std::optional<ConvertedFace>> converted, const LoadOptions& options,
                          const Control& control) {
    try {
        IMeshTools_Parameters parameters;
        parameters.Deflection = options.chord;
        parameters.Angle = options.angle;
        parameters.InParallel = true;
        BRepMesh_IncrementalMesh mesher(shape, parameters);
        if (control.cancelled()) return fail_cancelled("triangulation");

        // All nodes of all faces, face after face.
        const std::size_t count = static_cast<std::size_t>(faces.Extent());
        std::vector<std::uint32_t> first_node(count + 1, 0);
        std::vector<Handle(Poly_Triangulation)> triangulations(count);
        std::vector<Vec3> nodes;
        ShapeMesh result;
        for (std::size_t f = 0; f < count; ++f) {
            TopLoc_Location location;
            const TopoDS_Face& face = TopoDS::Face(faces(static_cast<int>(f) + 1));
            triangulations[f] = BRep_Tool::Triangulation(face, location);
            if (triangulations[f].IsNull() || triangulations[f]->NbTriangles() == 0) {
                result.bare.push_back(static_cast<std::uint32_t>(f));
            } else {
                const gp_Trsf transformation = location.Transformation();
                for (int n = 1; n <= triangulations[f]->NbNodes(); ++n) {
                    const gp_Pnt p = triangulations[f]->Node(n).Transformed(transformation);
                    nodes.emplace_back(p.X(), p.Y(), p.Z());
                }
            }
            first_node[f + 1] = static_cast<std::uint32_t>(nodes.size());
        }

        // Shared edges: their nodes correspond one to one on all faces that use them. On a degenerate edge all are one point.
        UnionFind same(nodes.size());
        TopTools_IndexedDataMapOfShapeListOfShape edges;
        TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, edges);
        for (int e = 1; e <= edges.Extent(); ++e) {
            const TopoDS_Edge edge = TopoDS::Edge(edges.FindKey(e).Oriented(TopAbs_FORWARD));
            std::vector<std::vector<std::uint32_t>> chains;
            for (const TopoDS_Shape& face : edges(e)) {
                const int f = faces.FindIndex(face);
                if (f == 0) continue;
                for (auto& chain : chains_of(edge, TopoDS::Face(face), first_node[static_cast<std::size_t>(f) - 1]))
                    chains.push_back(std::move(chain));
            }
            for (std::size_t c = 0; c < chains.size(); ++c) {
                for (std::size_t k = 0; chains[c].size() == chains[0].size() && k < chains[c].size(); ++k)
                    same.unite(chains[0][k], chains[c][k]);
                for (std::size_t k = 1; BRep_Tool::Degenerated(edge) && k < chains[c].size(); ++k)
                    same.unite(chains[c][0], chains[c][k]);
            }
        }

        // Vertices in the order of first use; triangles in the order of faces, outward by the face's orientation.
        constexpr std::uint32_t kNone = ~0u;
        std::vector<std::uint32_t> vertex(nodes.size(), kNone);
        Mesh& mesh = result.mesh;
        for (std::size_t f = 0; f < count; ++f) {
            if (triangulations[f].IsNull()) continue;
            const bool reversed = faces(static_cast<int>(f) + 1).Orientation() == TopAbs_REVERSED;
            for (int t = 1; t <= triangulations[f]->NbTriangles(); ++t) {
                std::array<int, 3> n{};
                triangulations[f]->Triangle(t).Get(n[0], n[1], n[2]);
                if (reversed) std::swap(n[1], n[2]);
                std::array<std::uint32_t, 3> corner{};
                std::array<Vec2, 3> uv;
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t root = same.root(first_node[f] + static_cast<std::uint32_t>(n[k]) - 1);
                    if (vertex[root] == kNone) {
                        vertex[root] = static_cast<std::uint32_t>(mesh.vertices.size());
                        mesh.vertices.push_back(nodes[root]);
                    }
                    corner[k] = vertex[root];
                    uv[k] = Vec2::Zero();
                    if (converted[f] && triangulations[f]->HasUVNodes()) {
                        const gp_Pnt2d native = triangulations[f]->UVNode(n[k]);
                        uv[k] = converted[f]->uv({native.X(), native.Y()});
                    }
                }
                if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;  // at a pole
                mesh.triangles.push_back(corner);
                mesh.face.push_back(static_cast<std::uint32_t>(f));
                mesh.uv.push_back(uv);
            }
        }
        return result;
    } catch (const Standard_Failure& failure) {
        return fail(ErrorCode::unreadable,
                    fmt::format("the faces cannot be triangulated (Open CASCADE: {})", failure.GetMessageString()));
    }
}

}  // namespace trunnion::detail
