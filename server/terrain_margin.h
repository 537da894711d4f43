// Private to recall: how high the straight way to a site passes over the maps that are stored.
#pragma once

#include <optional>
#include <string>

#include "server/emergency.h"

namespace freelsd {

// Metres taken off a height over something in another altitude datum, or an unknown one.
double DatumPenalty(const std::string& given, const std::string& stored);

// Least height of the way over every stored map that it crosses, less the clearance; nothing where
// it crosses none.
std::optional<double> TerrainMargin(const Service& service,
                                    const EmergencyRequest& request,
                                    const GeoPoint& end);

}  // namespace freelsd
