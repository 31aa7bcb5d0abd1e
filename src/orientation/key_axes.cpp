#include "trunnion/orientation/key_axes.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "orientation/lean.hpp"

namespace trunnion {

Result<std::vector<Vec3>> KeyAxes::operator()(const ContactPath& path, const Scene&, const Control& control) const {
    if (control.cancelled()) return fail_cancelled("orientation");
    if (keys.empty()) return fail(ErrorCode::invalid_input, "keys is empty; give at least one, [fraction, i, j, k]");
    std::vector<Vec3> axis;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const auto unit = UnitVector::from(keys[k].axis);
        if (!unit) return fail(ErrorCode::invalid_input, fmt::format("keys: key {} has a zero direction", k));
        if (!(keys[k].at >= 0.0 && keys[k].at <= 1.0) || (k > 0 && !(keys[k].at > keys[k - 1].at)))
            return fail(
                ErrorCode::invalid_input,
                fmt::format("keys: key {} stands at {:.6g}; fractions go from 0 to 1 and grow from key to key", k, keys[k].at));
        axis.push_back(*unit);
        constexpr double kOpposite = 1e-6;
        if (k > 0 && (axis[k] + axis[k - 1]).norm() < kOpposite)
            return fail(ErrorCode::no_solution,
                        fmt::format("keys: axes {} and {} are opposite; give one between them", k - 1, k));
    }
    ToolAxes axes(path.size());
    for (const ContactPass& pass : path.passes) {
        std::vector<double> t(pass.count, 0.0);
        for (std::size_t j = 1; j < pass.count; ++j)
            t[j] = t[j - 1] + (path.cc[pass.first + j] - path.cc[pass.first + j - 1]).norm();
        const double length = pass.count > 0 && t.back() > 0.0 ? t.back() : 1.0;
        std::size_t k = 0;
        for (std::size_t j = 0; j < pass.count; ++j) {
            const double at = t[j] / length;
            while (k + 1 < keys.size() && keys[k + 1].at <= at) ++k;
            Vec3& T = axes[pass.first + j];
            if (at <= keys.front().at)
                T = axis.front();
            else if (k + 1 == keys.size())
                T = axis.back();
            else
                T = slerp(axis[k], axis[k + 1], (at - keys[k].at) / (keys[k + 1].at - keys[k].at)).normalized();
        }
    }
    return axes;
}

}  // namespace trunnion
