// Everything the tool must not cut or touch, indexed once.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "trunnion/part/part.hpp"

namespace trunnion {

/// A body nothing may touch: vise, clamp, machine table.
struct CheckBody {
    std::string name;
    std::shared_ptr<const Part> part;
};

/// The part and the check bodies in one tree of boxes. Immutable, cheap to copy, thread-safe.
/// A triangle of a face with a surface stands for the exact surface over its (u, v) triangle, not for itself.
class CheckScene {
public:
    /// Error: invalid_input if there is not one triangle.
    static Result<CheckScene> build(std::shared_ptr<const Part> part, std::vector<CheckBody> bodies);

    const Part& part() const;
    const std::vector<CheckBody>& bodies() const;
    std::size_t triangle_count() const;
    /// Whether the point lies inside a closed body (part: -1, bodies: their index); empty if in none. Open bodies hold
    /// nothing. By the parity of crossings of three rays that must agree two to one.
    std::optional<int> inside_which(const Vec3& point) const;

    struct Index;  // src/check/scene_index.hpp
    const Index& index() const { return *index_; }

private:
    CheckScene() = default;
    std::shared_ptr<const Index> index_;
};

}  // namespace trunnion
