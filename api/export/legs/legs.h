// Legs to fly next as GeoJSON, and as surveys of QGroundControl.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/api.h"
#include "api/export/sites/sites.h"
#include "engine/next_look/next_look.h"

namespace freelsd {

// A site that the legs may turn, in the order of LookRequest::sites.
struct LookSiteName {
  std::string site_id;
  std::string verdict;
};

// FeatureCollection of LineStrings in the order of flight, with the gain of all of them.
nlohmann::json LegsJson(const NextLook& look,
                        const std::vector<LookSiteName>& sites,
                        const FlightContext& context);
// Throws ApiError AltitudeUnknown if the altitudes are neither above mean sea level nor can be told
// above home.
void RequireAltitudes(const FlightContext& context, const ExportOptions& options);
// One survey item per leg. Throws as RequireAltitudes does, and ApiError NothingToLookAt if there
// is no leg.
std::string LegsPlan(const NextLook& look,
                     const FlightContext& context,
                     const ExportOptions& options);

}  // namespace freelsd
