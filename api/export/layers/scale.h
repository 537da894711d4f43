// Private to layers/. Values of a site's layer at the two ends of its ramp.
#pragma once

#include <string>

#include "api/export/layers/layers.h"

namespace freelsd {

// For slope, roughness and grass they are fixed, so that pictures of different sites are
// comparable; for other layers they depend on the seen values.
Scale ScaleOf(const SiteMap& site_map, const std::string& name);

}  // namespace freelsd
