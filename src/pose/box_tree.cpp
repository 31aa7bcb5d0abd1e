#include "pose/box_tree.hpp"

#include <algorithm>
#include <numeric>

namespace trunnion::detail {

BoxTree::BoxTree(const std::vector<Box3>& boxes, std::uint32_t leaf_size) {
    if (boxes.empty()) return;
    order_.resize(boxes.size());
    std::iota(order_.begin(), order_.end(), 0u);
    nodes_.reserve(4 * boxes.size() / leaf_size + 4);
    build(boxes, 0, static_cast<std::uint32_t>(boxes.size()), leaf_size);
}

void BoxTree::build(const std::vector<Box3>& boxes, std::uint32_t begin, std::uint32_t end, std::uint32_t leaf_size) {
    Box3 box, centres;
    for (std::uint32_t k = begin; k < end; ++k) {
        box.add(boxes[order_[k]]);
        centres.add(boxes[order_[k]].centre());
    }
    const std::size_t at = nodes_.size();
    nodes_.push_back({box.centre(), box.half(), begin, end - begin});
    if (end - begin <= leaf_size) return;
    Eigen::Index axis = 0;
    (centres.hi - centres.lo).maxCoeff(&axis);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t i, std::uint32_t j) {
                         const double a = boxes[i].lo[axis] + boxes[i].hi[axis], b = boxes[j].lo[axis] + boxes[j].hi[axis];
                         return a < b || (a == b && i < j);
                     });
    nodes_[at].count = 0;
    build(boxes, begin, middle, leaf_size);
    nodes_[at].first = static_cast<std::uint32_t>(nodes_.size());
    build(boxes, middle, end, leaf_size);
}

}  // namespace trunnion::detail
