// A field's report as the JSON object that plans hold as metrics.field (private).
#pragma once

#include <string>

#include "trunnion/orientation/orientation_field.hpp"

namespace trunnion::detail {

std::string field_json(const OrientationField& field);

}  // namespace trunnion::detail
