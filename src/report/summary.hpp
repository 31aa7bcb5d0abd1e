// The part of the page that a machinist reads first. Plain HTML: it needs no script.
#pragma once

#include <string>

#include "trunnion/report/html.hpp"

namespace trunnion::report {

/// Title, verdict with reasons, problems, checks, figures, set-up, warnings, further metrics.
std::string summary_html(const ReportInput& input);

}  // namespace trunnion::report
