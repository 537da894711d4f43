// Figures of a site's report: HTML and SVG text.
#pragma once

#include <string>

#include "api/export/site_export.h"

namespace freelsd {

// One layer with touchdown, final, circle, north and scale; without map only the lines.
std::string MapFigure(const SitePlaces& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer);
// Path and ground along the final; empty where there is no approach.
std::string ProfileFigure(const SitePlaces& site);

}  // namespace freelsd
