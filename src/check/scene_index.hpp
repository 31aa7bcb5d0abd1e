// The tree of boxes over all triangles of a scene (private to the check room).
#pragma once

#include <cstdint>

#include "trunnion/check/scene.hpp"

namespace trunnion {

struct CheckScene::Index {
    static constexpr int kDeepest = 128;  // levels of the tree, at most
    struct Node {
        Vec3 centre, half;        // box around the exact surface (triangle box grown by its deviation)
        std::uint32_t first = 0;  // leaf: first slot; inner: left child (the right one follows it)
        std::uint32_t count = 0;  // leaf: number of slots; inner: 0
    };
    struct Triangle {
        std::array<Vec3, 3> corner;
        double deviation = 0.0;    // surface within this of the flat triangle; 0 for plain triangles
        std::int32_t body = -1;    // -1: the part
        std::uint32_t face = 0;    // index into that body's faces
        std::uint32_t source = 0;  // index into that body's mesh
        bool exact = false;        // a surface stands behind it
    };

    std::shared_ptr<const Part> part;
    std::vector<CheckBody> bodies;
    std::vector<Node> nodes;          // root is 0
    std::vector<Triangle> triangles;  // in leaf order
    std::vector<bool> closed;         // [0] the part, [1 + i] body i

    const Part& owner(const Triangle& t) const { return t.body < 0 ? *part : *bodies[static_cast<std::size_t>(t.body)].part; }
};

}  // namespace trunnion
