#include "trunnion/orientation/fixed_vector.hpp"

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> FixedVector::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    const auto unit = UnitVector::from(axis);
    if (!unit) return fail(ErrorCode::invalid_input, "axis is a zero direction; give one such as [0, 0, 1]");
    if (control.cancelled()) return fail_cancelled("orientation");
    return ToolAxes(path.size(), unit->vec());
}

}  // namespace trunnion
