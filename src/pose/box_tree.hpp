// A tree of boxes over numbered items: tiles, spans, triangles (private).
#pragma once

#include <cstdint>
#include <vector>

#include "trunnion/base/vec.hpp"

namespace trunnion::detail {

/// Centre and half sizes: what every query needs.
struct BoxNode {
    Vec3 centre, half;
    std::uint32_t first = 0;  ///< leaf: first item in `order`; inner node: index of the right child (the left one follows)
    std::uint32_t count = 0;  ///< 0 = inner node
};

/// Built by median cuts along the longest side. Immutable.
class BoxTree {
public:
    BoxTree() = default;
    BoxTree(const std::vector<Box3>& boxes, std::uint32_t leaf_size);

    bool empty() const { return nodes_.empty(); }
    const std::vector<BoxNode>& nodes() const { return nodes_; }
    const std::vector<std::uint32_t>& order() const { return order_; }

    /// Calls item(index) for all items in leaves whose boxes, and all boxes above them, pass enter(node).
    template <class Enter, class Item>
    void visit(const Enter& enter, const Item& item) const {
        if (nodes_.empty()) return;
        std::uint32_t stack[64];  // the tree is balanced: its depth is the logarithm of the number of items
        int top = 0;
        stack[top++] = 0;
        while (top > 0) {
            const std::uint32_t at = stack[--top];
            const BoxNode& node = nodes_[at];
            if (!enter(node)) continue;
            if (node.count > 0) {
                for (std::uint32_t k = 0; k < node.count; ++k) item(order_[node.first + k]);
            } else {
                stack[top++] = node.first;
                stack[top++] = at + 1;
            }
        }
    }

private:
    void build(const std::vector<Box3>& boxes, std::uint32_t begin, std::uint32_t end, std::uint32_t leaf_size);
    std::vector<BoxNode> nodes_;
    std::vector<std::uint32_t> order_;
};

}  // namespace trunnion::detail
