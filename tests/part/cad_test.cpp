// Real files, and primitives written by Open CASCADE, against closed forms and the published volumes.
#include <filesystem>
#include <fstream>
#include <random>

#include <unistd.h>

#include <gtest/gtest.h>

#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <gp_Trsf.hxx>

#include "part/mesh_tools.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {
namespace {

namespace fs = std::filesystem;

fs::path carried(const std::string& name) {
    return fs::path(TRUNNION_SOURCE_DIR) / "data/parts" / name;
}

#define SHARED_PART(variable, name)                                     \
    const fs::path variable = fs::path(TRUNNION_SHARED_PARTS) / (name); \
    if (!fs::exists(variable)) GTEST_SKIP() << "needs the shared part " << (name)

/// What must hold for every CAD part: bounds against samples, orientation, uv inside the trim.
void expect_sound(const Part& part, double chord, std::size_t stride) {
    const Mesh& m = part.mesh;
    ASSERT_EQ(m.deviation.size(), m.triangles.size());
    double worst = 0.0, greatest = 0.0, area = 0.0, turned = 0.0;
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        greatest = std::max(greatest, m.deviation[t]);
        if (t % stride != 0 || !part.faces[m.face[t]].surface) continue;
        const Surface& s = *part.faces[m.face[t]].surface;
        for (int i = 0; i <= 4; ++i)
            for (int j = 0; i + j <= 4; ++j) {
                const double a = i / 4.0, b = j / 4.0, c = 1.0 - a - b;
                const Vec2 uv = a * m.uv[t][0] + b * m.uv[t][1] + c * m.uv[t][2];
                const Vec3 flat =
                    a * m.vertices[m.triangles[t][0]] + b * m.vertices[m.triangles[t][1]] + c * m.vertices[m.triangles[t][2]];
                const double rounding = 64 * std::numeric_limits<double>::epsilon() * flat.norm();  // of the two evaluations here
                worst = std::max(worst, ((s.point(uv.x(), uv.y()) - flat).norm() - rounding) / m.deviation[t]);
            }
        const Vec2 uv = (m.uv[t][0] + m.uv[t][1] + m.uv[t][2]) / 3.0;
        const Vec3 area_vector = detail::area_vector(m, t);
        const auto n = s.normal(uv.x(), uv.y());
        area += area_vector.norm();
        if (n && area_vector.dot(*n) < 0.0) turned += area_vector.norm();
    }
    EXPECT_LE(worst, 1.0) << "a deviation is below the distance of samples";
    EXPECT_EQ(std::max(greatest, m.chord_error), m.chord_error);
    EXPECT_LE(turned, 1e-4 * area) << "triangles face against their surface";  // slivers along curved borders may
    for (const Face& face : part.faces) EXPECT_LE(face.trim.chord_error(), 0.2501 * chord);
}

Result<Part> load(const fs::path& file, double chord) {
    return load_part(file, {.chord = chord}, {});
}

void expect_solid(const fs::path& file, double chord, double volume, std::size_t faces) {
    const auto part = load(file, chord);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->faces.size(), faces);
    EXPECT_TRUE(part->closed);
    EXPECT_EQ(part->unit, "mm");
    EXPECT_LE(part->mesh.chord_error, chord);
    double area = 0.0;
    for (const Face& face : part->faces) {
        area += face.area;
        EXPECT_TRUE(face.surface) << face.index;
    }
    // The mesh lies within chord_error of the surface everywhere, so that the volumes differ by that times the area at most.
    EXPECT_NEAR(detail::volume(part->mesh), volume, part->mesh.chord_error * area);
    EXPECT_NEAR(detail::volume(part->mesh), volume, 1e-3 * volume);
    expect_sound(*part, chord, 7);
}

TEST(Cad, CarriedBladeAndMouldAreClosedSolidsOfTheirPublishedVolume) {
    expect_solid(carried("compressor_blade.step"), 0.02, 44452.4, 18);
    expect_solid(carried("mould_cavity.step"), 0.05, 909722.5, 23);
}
TEST(Cad, ImpellerIsAClosedSolidOfItsPublishedVolume) {
    SHARED_PART(file, "impeller.step");
    expect_solid(file, 0.05, 129719.5, 92);
}
TEST(Cad, BliskIsAClosedSolidOfItsPublishedVolume) {
    SHARED_PART(file, "blisk.step");
    expect_solid(file, 0.05, 327362.6, 82);
}

TEST(Cad, ThePanelIsTheSameByThreeFormats) {
    SHARED_PART(step, "body_panel.step");
    const auto a = load(step, 0.05), b = load(fs::path(step).replace_extension(".igs"), 0.05),
               c = load(fs::path(step).replace_extension(".stl"), 0.05);
    ASSERT_TRUE(a && b && c);
    for (const auto* part : {&*a, &*b, &*c}) {
        ASSERT_EQ(part->faces.size(), 1u);
        EXPECT_NEAR(part->faces[0].area, 149485.7, 2e-4 * 149485.7);
        EXPECT_LE((part->box.lo - a->box.lo).norm(), 0.1);
        EXPECT_LE((part->box.hi - a->box.hi).norm(), 0.1);
        EXPECT_FALSE(part->closed);
    }
    expect_sound(*a, 0.05, 5);
    // The same B-spline, up to the digits of the files and the sense of its parameters.
    const Surface &s = *a->faces[0].surface, &i = *b->faces[0].surface;
    EXPECT_EQ(a->faces[0].kind, "bspline");
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < 50; ++k) {
        const Vec2 uv(s.domain().u.at(unit(random)), s.domain().v.at(unit(random)));
        const Vec3 p = s.point(uv.x(), uv.y());
        const Vec2 other = detail::project(i, p,
                                           {i.domain().u.at((uv.x() - s.domain().u.lo) / s.domain().u.length()),
                                            i.domain().v.at((uv.y() - s.domain().v.lo) / s.domain().v.length())});
        EXPECT_LE((i.point(other.x(), other.y()) - p).norm(), 1e-6);
    }
    // Trimmed: the mesh's triangles are inside the loops, the wheel arch is not.
    ASSERT_FALSE(a->faces[0].trim.whole_domain());
    std::size_t outside = 0;
    for (const auto& uv : a->mesh.uv) outside += !a->faces[0].trim.contains((uv[0] + uv[1] + uv[2]) / 3.0);
    EXPECT_LE(outside, a->mesh.uv.size() / 1000);
}

TEST(Cad, AnInchFileArrivesInMillimetres) {
    SHARED_PART(file, "nist_ftc_07_asme1_ap242-e2.stp");
    const auto part = load(file, 0.1);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->unit, "inch");
    EXPECT_EQ(part->faces.size(), 306u);
    EXPECT_NEAR(part->box.hi.x(), 155.8, 0.1);
    EXPECT_NEAR(part->box.lo.y(), -123.2, 0.1);
    EXPECT_NEAR(part->box.hi.y(), 12.7, 0.1);
    // The file's own edges lie up to 0.104 mm off its faces (the tolerance it declares for them); the mesh says so.
    EXPECT_LE(part->mesh.chord_error, 0.1 + 0.105);
    ASSERT_FALSE(part->problems.empty());
    EXPECT_NE(part->problems[0].find("edges of the model lie up to 0.10"), std::string::npos) << part->problems[0];
    expect_sound(*part, 0.1, 11);
}

/// The mesh of the first n faces only.
Mesh first_faces(const Mesh& mesh, std::uint32_t count) {
    Mesh out;
    out.vertices = mesh.vertices;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (mesh.face[t] < count) out.triangles.push_back(mesh.triangles[t]), out.face.push_back(mesh.face[t]);
    return out;
}

TEST(Cad, TheSolidOfANistFileIsClosedAndItsLooseSheetsComeAfterIt) {
    SHARED_PART(file, "nist_ctc_02_asme1_ap242-e2.stp");
    const auto part = load(file, 0.2);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->faces.size(), 637u);
    const Mesh solid = first_faces(part->mesh, 635);
    EXPECT_TRUE(is_closed(solid));
    EXPECT_GT(detail::volume(solid), 0.0);
    EXPECT_FALSE(part->closed);
    expect_sound(*part, 0.2, 11);
}

TEST(Cad, ATessellatedStepFileEndsInAClearError) {
    SHARED_PART(file, "nist_ftc_08_asme1_ap242-e1-tg.stp");
    const auto part = load(file, 0.1);
    ASSERT_FALSE(part);
    EXPECT_EQ(part.error().code, ErrorCode::unsupported);
    EXPECT_NE(part.error().message.find("tessellated"), std::string::npos);
}

TEST(Cad, ThePropellerIsSewnAndTheNacelleLoads) {
    SHARED_PART(propeller, "propeller_and_shaft.iges");
    const auto part = load(propeller, 0.5);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->faces.size(), 22u);
    EXPECT_NEAR(part->box.lo.x(), -1350, 0.5);
    const detail::EdgeCensus edges = detail::census(part->mesh);
    EXPECT_EQ(edges.open, 0u);  // sewn: no edge is left alone
    expect_sound(*part, 0.5, 11);

    SHARED_PART(nacelle, "nacelle.stp");
    const auto open = load(nacelle, 1.0);
    ASSERT_TRUE(open) << open.error().text();
    EXPECT_EQ(open->faces.size(), 6u);
    EXPECT_FALSE(open->closed);
    EXPECT_LE(open->mesh.chord_error, 1.0);
    expect_sound(*open, 1.0, 11);
}

class TemporaryFile {
public:
    explicit TemporaryFile(const std::string& name)
        : path_(fs::temp_directory_path() / ("trunnion-" + std::to_string(::getpid()) + "-" + name)) {}
    ~TemporaryFile() { fs::remove(path_); }
    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

TEST(Cad, PrimitivesInBrepFilesHaveTheirKindsAndVolumesAlsoWhenMoved) {
    gp_Trsf move;
    move.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, 2, -1)), 0.7);
    move.SetTranslationPart(gp_Vec(300, -200, 100));
    struct Case {
        TopoDS_Shape shape;
        double volume;
        std::string kind;
    };
    const std::vector<Case> cases{
        {BRepPrimAPI_MakeBox(10, 20, 30).Shape(), 6000.0, "plane"},
        {BRepPrimAPI_MakeSphere(15).Shape(), 4.0 / 3.0 * kPi * 15 * 15 * 15, "sphere"},
        {BRepPrimAPI_MakeCylinder(8, 25).Shape(), kPi * 64 * 25, "cylinder"},
        {BRepPrimAPI_MakeCylinder(8, 25, 2.0).Shape(), 64 * 25, "cylinder"},
        {BRepPrimAPI_MakeCone(12, 0, 20).Shape(), kPi * 144 * 20 / 3, "cone"},
        {BRepPrimAPI_MakeCone(12, 5, 20).Shape(), kPi * 20 * (144 + 60 + 25) / 3, "cone"},
        {BRepPrimAPI_MakeTorus(20, 6).Shape(), 2 * kPi * kPi * 20 * 36, "torus"},
    };
    for (const Case& c : cases)
        for (const bool moved : {false, true}) {
            const TemporaryFile file("primitive.brep");
            ASSERT_TRUE(BRepTools::Write(moved ? c.shape.Moved(TopLoc_Location(move)) : c.shape, file.path().c_str()));
            const auto part = load(file.path(), 0.02);
            ASSERT_TRUE(part) << part.error().text();
            EXPECT_TRUE(part->closed) << c.kind;
            EXPECT_LE(part->mesh.chord_error, 0.02) << c.kind;
            EXPECT_NEAR(detail::volume(part->mesh), c.volume, 0.01 * c.volume) << c.kind;
            EXPECT_TRUE(std::any_of(part->faces.begin(), part->faces.end(), [&](const Face& f) { return f.kind == c.kind; }));
            expect_sound(*part, 0.02, 1);
        }
}

TEST(Cad, DamagedFilesEndInOneSentence) {
    const auto head = [](const fs::path& from, double share) {
        std::ifstream in(from, std::ios::binary);
        std::string content((std::istreambuf_iterator<char>(in)), {});
        content.resize(static_cast<std::size_t>(static_cast<double>(content.size()) * share));
        return content;
    };
    const auto load_text = [](const std::string& name, const std::string& content) {
        const TemporaryFile file(name);
        std::ofstream(file.path(), std::ios::binary) << content;
        return load(file.path(), 0.1);
    };
    for (const double share : {0.2, 0.7, 0.999}) {
        const auto part = load_text("cut.step", head(carried("mould_cavity.step"), share));
        ASSERT_FALSE(part);
        EXPECT_EQ(part.error().code, ErrorCode::unreadable);
        EXPECT_NE(part.error().message.find("truncated"), std::string::npos) << part.error().message;
        EXPECT_NE(part.error().message.find("line "), std::string::npos);
    }
    const TemporaryFile whole("whole.brep");
    ASSERT_TRUE(BRepTools::Write(BRepPrimAPI_MakeSphere(15).Shape(), whole.path().c_str()));
    for (const double share : {0.05, 0.3, 0.6, 0.95}) {
        const auto part = load_text("cut.brep", head(whole.path(), share));
        ASSERT_FALSE(part) << share;
        EXPECT_EQ(part.error().code, ErrorCode::unreadable);
    }
    EXPECT_NE(load_text("empty.step", "").error().message.find("empty"), std::string::npos);
    EXPECT_EQ(load_text("text.step", "hello\n").error().code, ErrorCode::unreadable);
    EXPECT_EQ(load_text("text.igs", "hello\n").error().code, ErrorCode::unreadable);
    EXPECT_EQ(load_text("text.brep", "hello\n").error().code, ErrorCode::unreadable);
    EXPECT_EQ(load_text("nofaces.step", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n").error().code,
              ErrorCode::unreadable);
}

TEST(Cad, ACancelledLoadSaysSo) {
    std::atomic<bool> cancel{true};
    Control control;
    control.cancel = &cancel;
    const auto part = load_part(carried("mould_cavity.step"), {}, control);
    ASSERT_FALSE(part);
    EXPECT_EQ(part.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace trunnion
