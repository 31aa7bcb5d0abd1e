#include "part/occt_read.hpp"

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>

#include <fmt/format.h>

#include "part/mesh_tools.hpp"
#include "part/occt_mesh.hpp"
#include "trunnion/base/file.hpp"
#include "trunnion/base/parallel.hpp"

namespace trunnion::detail {

namespace {

constexpr std::size_t kMostTriangles = 8'000'000;
constexpr double kSewing = 0.01;  // mm: gaps up to here between IGES faces are taken for shared edges

struct Read {
    TopoDS_Shape shape;
    std::string unit;
};

tl::unexpected<Error> unreadable(std::string message) {
    return fail(ErrorCode::unreadable, std::move(message));
}

/// "mm", "inch", "m", ... from the words of the formats.
std::string plain_unit(std::string word) {
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (word == "millimetre" || word == "millimeter" || word == "mm" || word.empty()) return "mm";
    if (word == "metre" || word == "meter" || word == "m") return "m";
    if (word == "centimetre" || word == "centimeter" || word == "cm") return "cm";
    if (word == "in" || word == "inch" || word == "inches") return "inch";
    if (word == "ft" || word == "foot") return "foot";
    return word;
}

std::size_t line_of(std::string_view content) {
    return static_cast<std::size_t>(std::count(content.begin(), content.end(), '\n')) + 1;
}

Result<Read> read_step(const std::filesystem::path& file, const std::string& content) {
    if (content.find("ISO-10303-21") == std::string::npos)
        return unreadable("line 1: this is not a STEP file, it does not begin with ISO-10303-21");
    if (content.rfind("END-ISO-10303-21") == std::string::npos)
        return unreadable(
            fmt::format("line {}: the file ends before END-ISO-10303-21: it is truncated, export it again", line_of(content)));
    STEPControl_Reader reader;
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone)
        return unreadable("Open CASCADE cannot read this STEP file: export it again");
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.FileUnits(lengths, angles, solid_angles);
    reader.TransferRoots();
    const TopoDS_Shape shape = reader.OneShape();
    if (shape.IsNull() || !TopExp_Explorer(shape, TopAbs_FACE).More()) {
        if (content.find("TESSELLATED_") != std::string::npos || content.find("TRIANGULATED_FACE") != std::string::npos)
            return fail(ErrorCode::unsupported,
                        "the STEP file holds only tessellated faces and no boundary representation: export it as AP203, AP214 or "
                        "AP242 with exact geometry, or as STL");
        return unreadable("the STEP file holds no faces");
    }
    return Read{shape, plain_unit(lengths.IsEmpty() ? "" : lengths.First().ToCString())};
}

Result<Read> read_iges(const std::filesystem::path& file, const std::string& content) {
    // Fixed columns: the section letter stands in column 73, the last line is the terminate section.
    const std::size_t end = content.find_last_not_of(" \r\n");
    const std::size_t begin = end == std::string::npos ? 0 : content.rfind('\n', end) + 1;
    if (end == std::string::npos || end - begin < 72 || content[begin + 72] != 'T')
        return unreadable(fmt::format("line {}: the file ends before its terminate section: it is truncated or no IGES file",
                                      line_of(content.substr(0, end == std::string::npos ? 0 : end))));
    IGESControl_Reader reader;
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone)
        return unreadable("Open CASCADE cannot read this IGES file: export it again");
    const Handle(IGESData_IGESModel) model = Handle(IGESData_IGESModel)::DownCast(reader.Model());
    std::string unit = "mm";
    if (!model.IsNull() && !model->GlobalSection().UnitName().IsNull())
        unit = plain_unit(model->GlobalSection().UnitName()->ToCString());
    reader.TransferRoots();
    const TopoDS_Shape loose = reader.OneShape();
    if (loose.IsNull() || !TopExp_Explorer(loose, TopAbs_FACE).More()) return unreadable("the IGES file holds no faces");
    BRepBuilderAPI_Sewing sewing(kSewing);
    sewing.Add(loose);
    sewing.Perform();
    const TopoDS_Shape sewn = sewing.SewedShape();
    if (sewn.IsNull() || !TopExp_Explorer(sewn, TopAbs_FACE).More()) return Read{loose, unit};
    // Closed shells become solids with the material inside: IGES faces carry no reliable orientation.
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    for (TopExp_Explorer s(sewn, TopAbs_SHELL); s.More(); s.Next()) {
        if (!BRep_Tool::IsClosed(s.Current())) {
            builder.Add(all, s.Current());
            continue;
        }
        TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(s.Current()));
        BRepLib::OrientClosedSolid(solid);
        builder.Add(all, solid);
    }
    for (TopExp_Explorer f(sewn, TopAbs_FACE, TopAbs_SHELL); f.More(); f.Next()) builder.Add(all, f.Current());
    return Read{all, unit};
}

Result<Read> read_brep(const std::filesystem::path& file, const std::string& content) {
    // The kernel's reader trusts the file and prints what it dislikes: what can be known before is checked here.
    if (content.substr(0, 256).find("CASCADE Topology V") == std::string::npos)
        return unreadable("line 1: this is not a BREP file, it does not begin with CASCADE Topology");
    // "TShapes N", then N shapes whose lists of parts each end in a '*', then the root with its sign. On less it loops for ever.
    const std::size_t section = content.find("TShapes ");
    const std::string tail = section == std::string::npos ? "" : content.substr(section + 8);
    const std::size_t star = tail.rfind('*');
    if (star == std::string::npos || std::count(tail.begin(), tail.end(), '*') < std::atol(tail.c_str()) ||
        tail.find_first_of("+-", star) == std::string::npos)
        return unreadable(
            fmt::format("line {}: the file ends before its root shape: it is truncated, export it again", line_of(content)));
    BRep_Builder builder;
    TopoDS_Shape shape;
    if (!BRepTools::Read(shape, file.c_str(), builder) || shape.IsNull())
        return unreadable("Open CASCADE cannot read this BREP file: it is truncated or damaged");
    if (!TopExp_Explorer(shape, TopAbs_FACE).More()) return unreadable("the BREP file holds no faces");
    return Read{shape, "mm"};
}

/// Solids, then shells that belong to none, then loose faces.
TopoDS_Compound in_order(const TopoDS_Shape& shape) {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    for (TopExp_Explorer e(shape, TopAbs_SOLID); e.More(); e.Next()) builder.Add(all, e.Current());
    for (TopExp_Explorer e(shape, TopAbs_SHELL, TopAbs_SOLID); e.More(); e.Next()) builder.Add(all, e.Current());
    for (TopExp_Explorer e(shape, TopAbs_FACE, TopAbs_SHELL); e.More(); e.Next()) builder.Add(all, e.Current());
    return all;
}

/// What the mesh shows about the model: triangles that face against their surface (folds in the model or in its triangulation)
/// and edges that lie off their faces.
void report_mesh(Part& part, double chord) {
    const Mesh& mesh = part.mesh;
    std::vector<double> folded(part.faces.size(), 0.0);
    double offset = 0.0;
    std::vector<std::vector<std::size_t>> of_face(part.faces.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) of_face[mesh.face[t]].push_back(t);
    for (std::size_t f = 0; f < part.faces.size(); ++f) {
        const auto& surface = part.faces[f].surface;
        if (!surface) continue;
        std::vector<double> u, v;
        for (const std::size_t t : of_face[f]) {
            const Vec2 middle = (mesh.uv[t][0] + mesh.uv[t][1] + mesh.uv[t][2]) / 3.0;
            u.push_back(middle.x()), v.push_back(middle.y());
        }
        SurfaceBatch batch;
        surface->evaluate(u, v, 1, batch);
        for (std::size_t k = 0; k < of_face[f].size(); ++k) {
            const std::size_t t = of_face[f][k];
            const Vec3 Su(batch.plane(3)[k], batch.plane(4)[k], batch.plane(5)[k]);
            const Vec3 Sv(batch.plane(6)[k], batch.plane(7)[k], batch.plane(8)[k]);
            const Vec3 area = area_vector(mesh, t);
            if (surface->normal_sign() * Su.cross(Sv).dot(area) < 0.0) folded[f] += area.norm();
            if (mesh.deviation[t] <= chord) continue;
            for (std::size_t i = 0; i < 3; ++i)
                offset = std::max(
                    offset, (surface->point(mesh.uv[t][i].x(), mesh.uv[t][i].y()) - mesh.vertices[mesh.triangles[t][i]]).norm());
        }
    }
    std::vector<double> total(part.faces.size(), 0.0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) total[mesh.face[t]] += area_vector(mesh, t).norm();
    constexpr double kNoticed = 1e-3;  // of the face: flat slivers along a curved border may tilt over without harm
    for (Face& face : part.faces)
        if (const double area = folded[static_cast<std::size_t>(face.index)];
            area > kNoticed * total[static_cast<std::size_t>(face.index)])
            face.problems.push_back(
                fmt::format("inconsistent normals: {:.3g} mm2 of its triangles face against the surface", area));
    if (mesh.chord_error > chord)
        part.problems.push_back(fmt::format(
            "the mesh is within {:.3g} mm of the faces, not {:.3g}: edges of the model lie up to {:.3g} mm off its faces",
            mesh.chord_error, chord, offset));
}

Result<Part> part_of(const Read& read, const LoadOptions& options, const Control& control) {
    const TopoDS_Compound shape = in_order(read.shape);
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
    const std::size_t count = static_cast<std::size_t>(faces.Extent());
    Part part;
    part.unit = read.unit;
    part.faces.resize(count);
    std::vector<std::optional<ConvertedFace>> converted(count);
    auto done = parallel_for(count, 1, control, "surfaces", [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const TopoDS_Face& face = TopoDS::Face(faces(static_cast<int>(f) + 1));
            Face& ours = part.faces[f];
            ours.index = static_cast<int>(f);
            ours.kind = kind_of(face);
            Result<ConvertedFace> surface = convert_face(face);
            if (!surface) {
                ours.problems.push_back(
                    fmt::format("could not be converted ({}): it can be checked against, not machined", surface.error().message));
                continue;
            }
            TrimResult trimmed = trim_of(face, *surface, 0.25 * options.chord);
            ours.surface = surface->surface;
            ours.trim = std::move(trimmed.trim);
            ours.problems = std::move(trimmed.problems);
            converted[f] = std::move(*surface);
        }
    });
    if (!done) return fail_up(std::move(done));

    Result<ShapeMesh> mesh = mesh_of(shape, faces, converted, options, control);
    if (!mesh) return fail_up(std::move(mesh));
    part.mesh = std::move(mesh->mesh);
    for (const std::uint32_t f : mesh->bare)
        part.faces[f].problems.push_back("could not be triangulated: it is neither shown nor checked");
    if (auto refined = refine(part.mesh, part.faces, options.chord, kMostTriangles, control); !refined)
        return fail_up(std::move(refined));
    report_mesh(part, options.chord);
    for (const Face& face : part.faces) part.mesh.chord_error = std::max(part.mesh.chord_error, face.trim.chord_error());
    return part;
}

/// Open CASCADE's readers keep global state and print statistics: one file at a time, in silence.
std::mutex reader_mutex;

}  // namespace

Result<Part> read_cad(const std::filesystem::path& file, CadFormat format, const LoadOptions& options, const Control& control) {
    try {
        Result<Read> read = fail(ErrorCode::internal, "no reader");
        {
            const std::lock_guard lock(reader_mutex);
            Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
            control.report("reading", 0.0);
            const auto content = read_file(file);
            if (!content) return tl::unexpected<Error>(content.error());
            if (content->empty()) return unreadable("the file is empty");
            read = format == CadFormat::step   ? read_step(file, *content)
                   : format == CadFormat::iges ? read_iges(file, *content)
                                               : read_brep(file, *content);
        }
        if (!read) return fail_up(std::move(read));
        if (control.cancelled()) return fail_cancelled("reading");
        return part_of(*read, options, control);
    } catch (const Standard_Failure& failure) {
        return unreadable(fmt::format("Open CASCADE: {}", failure.GetMessageString()));
    }
}

}  // namespace trunnion::detail
