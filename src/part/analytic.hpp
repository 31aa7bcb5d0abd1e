// The analytic surfaces in closed form.
#pragma once

#include "trunnion/part/surface.hpp"

namespace trunnion::detail {

/// Error: invalid_input naming the length or angle that makes no surface.
Result<void> check_analytic(const AnalyticData& data);
Domain analytic_domain(const AnalyticData& data);
/// +1 where S_u x S_v points outward.
double analytic_sign(const AnalyticData& data);
SurfacePoint analytic_at(const AnalyticData& data, double u, double v);
SecondDerivativeBound analytic_bound(const AnalyticData& data, const Interval& u, const Interval& v);
std::string_view name_of(AnalyticKind kind);

}  // namespace trunnion::detail
