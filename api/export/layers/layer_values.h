// Private to layers/. The values of a layer as clients see them.
#pragma once

#include <string>

#include "api/export/layers/layers.h"

namespace freelsd {

// Values of a layer in the unit of LayerInfo (slope in degrees). Unseen cells are NaN. `hazard` has
// the values of Hazard and no NaN. `grass` is 1 for grass cells, else 0. Elevation is world z.
// Throws std::invalid_argument if no layer has the name.
cv::Mat1f LayerValues(const SiteMap& site_map, const std::string& name);

}  // namespace freelsd
