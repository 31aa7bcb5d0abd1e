#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <gtest/gtest.h>

#include "part/mesh_readers.hpp"
#include "part/mesh_tools.hpp"
#include "trunnion/part/part.hpp"

namespace trunnion {
namespace {

using Triangle = std::array<Vec3, 3>;

/// A cube of side 10, outward.
std::vector<Triangle> cube() {
    std::vector<Triangle> all;
    const auto quad = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
        all.push_back({a, b, c}), all.push_back({a, c, d});
    };
    const auto p = [](int i) { return Vec3((i & 1) ? 10 : 0, (i & 2) ? 10 : 0, (i & 4) ? 10 : 0); };
    quad(p(0), p(2), p(3), p(1)), quad(p(4), p(5), p(7), p(6)), quad(p(0), p(1), p(5), p(4));
    quad(p(2), p(6), p(7), p(3)), quad(p(0), p(4), p(6), p(2)), quad(p(1), p(3), p(7), p(5));
    return all;
}

std::string binary_stl(const std::vector<Triangle>& triangles, std::string header = "made by a test") {
    header.resize(80, '\0');
    const std::uint32_t count = static_cast<std::uint32_t>(triangles.size());
    std::string content = header + std::string(reinterpret_cast<const char*>(&count), 4);
    for (const Triangle& t : triangles) {
        content.append(12, '\0');
        for (const Vec3& p : t)
            for (int c = 0; c < 3; ++c) {
                const float value = static_cast<float>(p[c]);
                content.append(reinterpret_cast<const char*>(&value), 4);
            }
        content.append(2, '\0');
    }
    return content;
}

std::string ascii_stl(const std::vector<Triangle>& triangles) {
    std::string content = "solid cube\n";
    for (const Triangle& t : triangles) {
        content += " facet normal 0 0 0\n  outer loop\n";
        for (const Vec3& p : t)
            content += "   vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
        content += "  endloop\n endfacet\n";
    }
    return content + "endsolid cube\n";
}

class TemporaryFile {
public:
    TemporaryFile(const std::string& name, const std::string& content)
        : path_(std::filesystem::temp_directory_path() / ("trunnion-" + std::to_string(::getpid()) + "-" + name)) {
        std::ofstream(path_, std::ios::binary) << content;
    }
    ~TemporaryFile() { std::filesystem::remove(path_); }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

Result<Part> load(const std::string& name, const std::string& content) {
    const TemporaryFile file(name, content);
    return load_part(file.path(), {}, {});
}

void expect_cube(const Result<Part>& part) {
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->mesh.triangles.size(), 12u);
    EXPECT_EQ(part->mesh.vertices.size(), 8u);
    EXPECT_TRUE(part->closed);
    EXPECT_TRUE(is_closed(part->mesh));
    EXPECT_NEAR(detail::volume(part->mesh), 1000.0, 1e-9);
    EXPECT_EQ(part->faces.size(), 1u);
    EXPECT_EQ(part->faces[0].kind, "mesh");
    EXPECT_NEAR(part->faces[0].area, 600.0, 1e-9);
    EXPECT_TRUE(part->problems.empty());
    EXPECT_EQ(part->unit, "mm");
}

TEST(MeshReaders, ACubeArrivesFromBinaryAndAsciiStlAndObj) {
    expect_cube(load("cube.stl", binary_stl(cube())));
    expect_cube(load("cube.STL", ascii_stl(cube())));
    expect_cube(load("cube.stl", binary_stl(cube()) + "trailing"));
    std::string dos;
    for (const char c : ascii_stl(cube())) dos += c == '\n' ? std::string("\r\n") : std::string(1, c);
    expect_cube(load("cube.stl", dos));
    expect_cube(
        load("cube.obj",
             "# quads, mixed indices\nv 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 10 10 10\nv 0 10 10\nvt 0 "
             "0\nvn 0 0 1\n"
             "f 1/1 4/1 3/1 2/1\nf -4 -3 -2 -1\nf 1//1 2//1 6//1 5//1\nf 4/1/1 8/1/1 7/1/1 3/1/1\nf 1 5 8 4\nf 2 3 7 6\n"));
}

TEST(MeshReaders, ABinaryFileThatStartsWithSolidIsStillBinary) {
    expect_cube(load("solid.stl", binary_stl(cube(), "solid from a careless writer")));
}

TEST(MeshReaders, NegativeZeroIsZero) {
    std::vector<Triangle> triangles = cube();
    for (Triangle& t : triangles)
        for (Vec3& p : t)
            if (p.x() == 0.0 && p.y() == 10.0) p.x() = -0.0;
    expect_cube(load("zero.stl", binary_stl(triangles)));
}

TEST(MeshReaders, DegenerateTrianglesAreLeftOutAndCounted) {
    std::vector<Triangle> triangles = cube();
    triangles.push_back({Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(2, 2, 2)});
    const auto part = load("degenerate.stl", binary_stl(triangles));
    ASSERT_TRUE(part);
    EXPECT_EQ(part->mesh.triangles.size(), 12u);
    ASSERT_EQ(part->problems.size(), 1u);
    EXPECT_NE(part->problems[0].find("1 degenerate"), std::string::npos);
}

TEST(MeshReaders, OpenInsideOutAndTwistedMeshesAreReported) {
    const auto problem = [](const std::vector<Triangle>& triangles) {
        const auto part = load("p.stl", binary_stl(triangles));
        return part && part->problems.size() == 1 ? part->problems[0] : std::string("?");
    };
    std::vector<Triangle> open = cube(), inside_out = cube(), twisted = cube();
    open.pop_back();
    for (Triangle& t : inside_out) std::swap(t[1], t[2]);
    std::swap(twisted[0][1], twisted[0][2]);
    EXPECT_NE(problem(open).find("open shell: 3 "), std::string::npos);
    EXPECT_NE(problem(inside_out).find("inside out"), std::string::npos);
    EXPECT_NE(problem(twisted).find("inconsistent normals: 3 "), std::string::npos);
}

TEST(MeshReaders, EveryBadFileEndsInOneSentenceThatSaysWhere) {
    struct Case {
        const char* name;
        std::string content, expected;
    };
    std::vector<Triangle> nan = cube();
    nan[7][1].y() = std::nan("");
    std::string truncated = binary_stl(cube());
    truncated.resize(truncated.size() - 120);
    std::string cut = ascii_stl(cube());
    cut.resize(cut.size() / 2);
    const std::vector<Case> cases{
        {"empty.stl", "", "the file is empty"},
        {"blank.stl", "  \n", "the file is empty"},
        {"none.stl", binary_stl({}), "no triangles"},
        {"none2.stl", "solid x\nendsolid x\n", "no triangles"},
        {"nan.stl", binary_stl(nan), "triangle 7: "},
        {"truncated.stl", truncated, "triangle 9: "},
        {"cut.stl", cut, "truncated"},
        {"word.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\n", "line 4: \"zero\""},
        {"inf.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 inf 0\n", "line 4: "},
        {"short.stl", "abc", "too few"},
        {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: vertex index 4 does not exist, there are 3"},
        {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4: vertex index 0"},
        {"back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", "line 4: vertex index -4"},
        {"two.obj", "v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: a face of 2"},
        {"nan.obj", "v 0 nan 0\n", "line 1: "},
        {"empty.obj", "", "no vertices"},
    };
    for (const Case& c : cases) {
        const auto part = load(c.name, c.content);
        ASSERT_FALSE(part) << c.name;
        EXPECT_EQ(part.error().code, ErrorCode::unreadable) << c.name;
        EXPECT_NE(part.error().message.find(c.expected), std::string::npos) << c.name << ": " << part.error().message;
        EXPECT_NE(part.error().text().find(c.name), std::string::npos);
    }
    EXPECT_EQ(load_part("no-such-file.stl", {}, {}).error().code, ErrorCode::not_found);
    EXPECT_EQ(load("part.xyz", "x").error().code, ErrorCode::unsupported);
}

}  // namespace
}  // namespace trunnion
