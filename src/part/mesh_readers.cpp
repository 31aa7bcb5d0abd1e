#include "part/mesh_readers.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

namespace trunnion::detail {

namespace {

tl::unexpected<Error> unreadable(std::string message) {
    return fail(ErrorCode::unreadable, std::move(message));
}

/// Vertices with bitwise equal coordinates become one (-0 counts as 0): open addressing, linear in the vertices.
class Welder {
public:
    explicit Welder(std::size_t expected) { rehash(std::bit_ceil(2 * expected + 16)); }

    std::uint32_t add(const Vec3& given) {
        const Vec3 p = given + Vec3::Zero();  // -0 + 0 = +0
        if (2 * (vertices_.size() + 1) > table_.size()) rehash(2 * table_.size());
        for (std::size_t slot = hash(p) & (table_.size() - 1);; slot = (slot + 1) & (table_.size() - 1)) {
            std::uint32_t& entry = table_[slot];
            if (entry == kEmpty) {
                entry = static_cast<std::uint32_t>(vertices_.size());
                vertices_.push_back(p);
                return entry;
            }
            if (vertices_[entry] == p) return entry;
        }
    }
    std::vector<Vec3> take() { return std::move(vertices_); }

private:
    static constexpr std::uint32_t kEmpty = ~0u;
    static std::size_t hash(const Vec3& p) {
        std::uint64_t h = 0;
        for (int c = 0; c < 3; ++c) {
            h ^= std::bit_cast<std::uint64_t>(p[c]);
            h *= 0x9E3779B97F4A7C15ull;
            h ^= h >> 32;
        }
        return static_cast<std::size_t>(h);
    }
    void rehash(std::size_t size) {
        table_.assign(size, kEmpty);
        for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
            std::size_t slot = hash(vertices_[v]) & (size - 1);
            while (table_[slot] != kEmpty) slot = (slot + 1) & (size - 1);
            table_[slot] = v;
        }
    }
    std::vector<std::uint32_t> table_;
    std::vector<Vec3> vertices_;
};

/// Triangles as they come, degenerate ones counted and left out.
struct Triangles {
    std::vector<std::array<std::uint32_t, 3>> kept;
    std::size_t degenerate = 0;

    /// Two corners in one vertex: no triangle. A sliver with three vertices stays, its neighbours need its edges.
    void add(const std::array<std::uint32_t, 3>& t) {
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            ++degenerate;
        else
            kept.push_back(t);
    }
};

Result<Part> finish(std::vector<Vec3> vertices, Triangles triangles) {
    if (triangles.kept.empty()) {
        return unreadable(triangles.degenerate == 0
                              ? "the file holds no triangles"
                              : fmt::format("all {} triangles are degenerate (no area)", triangles.degenerate));
    }
    Part part;
    part.unit = "mm";
    part.mesh.vertices = std::move(vertices);
    part.mesh.triangles = std::move(triangles.kept);
    part.mesh.face.assign(part.mesh.triangles.size(), 0);
    Face face;
    face.kind = "mesh";
    part.faces.push_back(std::move(face));
    if (triangles.degenerate > 0)
        part.problems.push_back(fmt::format("{} degenerate triangles (no area) were left out", triangles.degenerate));
    return part;
}

bool blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

/// Words of a text, with the line they stand on.
struct Words {
    std::string_view text;
    std::size_t at = 0, line = 1;

    /// The next word of any line; empty at the end.
    std::string_view next() {
        skip(false);
        return word();
    }
    /// The next word of this line; empty at its end.
    std::string_view next_on_line() {
        skip(true);
        return word();
    }
    void next_line() {
        while (at < text.size() && text[at] != '\n') ++at;
        if (at < text.size()) ++at, ++line;
    }
    bool done() const { return at >= text.size(); }

private:
    void skip(bool stay) {
        while (at < text.size() && blank(text[at]) && !(stay && text[at] == '\n')) {
            if (text[at] == '\n') ++line;
            ++at;
        }
    }
    std::string_view word() {
        const std::size_t begin = at;
        while (at < text.size() && !blank(text[at])) ++at;
        return text.substr(begin, at - begin);
    }
};

bool parse(std::string_view word, double& value) {
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size();
}

/// Three finite coordinates. Error names the line.
Result<Vec3> vertex_from(Words& words) {
    Vec3 p;
    for (int c = 0; c < 3; ++c) {
        const std::string_view word = words.next_on_line();
        if (word.empty()) return unreadable(fmt::format("line {}: a vertex needs three coordinates", words.line));
        if (!parse(word, p[c]))
            return unreadable(fmt::format("line {}: \"{}\" is not a coordinate", words.line, word.substr(0, 40)));
        if (!std::isfinite(p[c]))
            return unreadable(fmt::format("line {}: the coordinate {} is not a finite number", words.line, word));
    }
    return p;
}

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;

Result<Part> read_stl_binary(std::string_view content, std::uint32_t count) {
    Welder welder(count);
    Triangles triangles;
    triangles.kept.reserve(count);
    for (std::size_t t = 0; t < count; ++t) {
        std::array<float, 9> value;
        std::memcpy(value.data(), content.data() + kStlHeader + t * kStlTriangle + 12, sizeof value);
        std::array<std::uint32_t, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 p(value[3 * k], value[3 * k + 1], value[3 * k + 2]);
            if (!p.allFinite())
                return unreadable(
                    fmt::format("triangle {}: a coordinate is not a finite number ({}, {}, {})", t, p.x(), p.y(), p.z()));
            corner[k] = welder.add(p);
        }
        triangles.add(corner);
    }
    return finish(welder.take(), std::move(triangles));
}

Result<Part> read_stl_ascii(std::string_view content) {
    Words words{content};
    Welder welder(content.size() / 100);
    Triangles triangles;
    std::vector<std::uint32_t> loop;
    bool in_facet = false, ended = false;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        if (word == "vertex") {
            auto p = vertex_from(words);
            if (!p) return fail_up(std::move(p));
            if (!in_facet) return unreadable(fmt::format("line {}: a vertex outside a facet", words.line));
            loop.push_back(welder.add(*p));
        } else if (word == "facet") {
            if (in_facet) return unreadable(fmt::format("line {}: a facet begins before the last one has ended", words.line));
            in_facet = true, ended = false;
            loop.clear();
            words.next_line();  // "normal i j k": derived again from the vertices
        } else if (word == "endfacet") {
            if (loop.size() != 3)
                return unreadable(fmt::format("line {}: a facet of {} vertices where 3 are needed", words.line, loop.size()));
            in_facet = false;
            triangles.add({loop[0], loop[1], loop[2]});
        } else if (word == "solid" || word == "endsolid") {
            ended = word == "endsolid";
            words.next_line();
        } else if (word == "outer") {
            words.next_line();
        } else if (word != "endloop") {
            if (words.done()) break;  // cut off within a word
            return unreadable(fmt::format("line {}: \"{}\" has no meaning in an STL file", words.line, word.substr(0, 40)));
        }
    }
    if (in_facet || !ended)
        return unreadable(fmt::format("line {}: the file ends before \"endsolid\": it is truncated", words.line));
    return finish(welder.take(), std::move(triangles));
}

}  // namespace

Result<Part> read_stl(std::string_view content) {
    const std::size_t first = content.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return unreadable("the file is empty");
    const bool says_solid = content.substr(first).starts_with("solid");
    if (content.size() >= kStlHeader) {
        std::uint32_t count = 0;
        std::memcpy(&count, content.data() + 80, 4);
        const std::size_t needed = kStlHeader + kStlTriangle * static_cast<std::size_t>(count);
        if (content.size() == needed) return read_stl_binary(content, count);
        // Text has no zero bytes and no control characters in its first lines; a binary header or count nearly always has.
        const std::string_view head = content.substr(0, std::min<std::size_t>(content.size(), 512));
        const bool text = head.find_first_of(std::string_view("\0\1\2\3\4\5\6\7", 8)) == std::string_view::npos;
        if (!(says_solid && text)) {
            if (content.size() < needed)
                return unreadable(fmt::format("triangle {}: the file ends here, but it announces {} triangles: it is truncated",
                                              (content.size() - kStlHeader) / kStlTriangle, count));
            return read_stl_binary(content, count);  // trailing bytes, as some writers leave
        }
    }
    if (!says_solid)
        return unreadable(fmt::format("{} bytes are too few for a binary STL file, and it is no ASCII one", content.size()));
    return read_stl_ascii(content);
}

Result<Part> read_obj(std::string_view content) {
    Words words{content};
    std::vector<Vec3> given;
    std::vector<std::vector<std::int64_t>> polygons;
    std::vector<std::size_t> lines;
    for (; !words.done(); words.next_line()) {
        const std::string_view keyword = words.next_on_line();
        if (keyword == "v") {
            auto p = vertex_from(words);
            if (!p) return fail_up(std::move(p));
            given.push_back(*p);
        } else if (keyword == "f") {
            std::vector<std::int64_t> polygon;
            for (std::string_view word = words.next_on_line(); !word.empty(); word = words.next_on_line()) {
                std::int64_t index = 0;
                const std::string_view number = word.substr(0, word.find('/'));
                const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
                if (error != std::errc{} || end != number.data() + number.size())
                    return unreadable(fmt::format("line {}: \"{}\" is not a vertex index", words.line, word.substr(0, 40)));
                const std::int64_t count = static_cast<std::int64_t>(given.size());
                if (index < 0 && index >= -count)
                    index += count;  // counted back from the last vertex
                else
                    --index;
                // Forward references are legal; they are checked when all vertices are known.
                if (index < 0) return unreadable(fmt::format("line {}: vertex index {} does not exist", words.line, number));
                polygon.push_back(index);
            }
            if (polygon.size() < 3)
                return unreadable(
                    fmt::format("line {}: a face of {} vertices where at least 3 are needed", words.line, polygon.size()));
            polygons.push_back(std::move(polygon));
            lines.push_back(words.line);
        }
    }
    if (given.empty() && polygons.empty()) return unreadable("the file holds no vertices and no faces");

    Welder welder(given.size());
    std::vector<std::uint32_t> welded;
    welded.reserve(given.size());
    for (const Vec3& p : given) welded.push_back(welder.add(p));
    Triangles triangles;
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        for (const std::int64_t index : polygons[f])
            if (index >= static_cast<std::int64_t>(welded.size()))
                return unreadable(
                    fmt::format("line {}: vertex index {} does not exist, there are {}", lines[f], index + 1, welded.size()));
        const auto at = [&](std::size_t k) { return welded[static_cast<std::size_t>(polygons[f][k])]; };
        for (std::size_t k = 1; k + 1 < polygons[f].size(); ++k) triangles.add({at(0), at(k), at(k + 1)});
    }
    return finish(welder.take(), std::move(triangles));
}

}  // namespace trunnion::detail
