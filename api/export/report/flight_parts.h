// Private to report/. The sections of a flight's report.
#pragma once

#include <string>

#include "api/export/report/report.h"

namespace freelsd {

std::string SitesSection(const FlightReport& report);
std::string QualitySection(const FlightReport& report);
std::string LeftOutSection(const FlightReport& report);

// "1 photograph", "2 photographs".
std::string CountText(int64_t count, const std::string& one);

}  // namespace freelsd
