// Private to report/. Figures of a site's report as HTML and SVG text.
#pragma once

#include <string>

#include "api/stored/stored.h"

namespace freelsd {

// One layer with touchdown, final, circle, north arrow and scale. If the map is empty, the figure
// has no layer.
std::string MapFigure(const StoredSite& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer);
// Heights of path and terrain along the final; empty if the site has no approach.
std::string ProfileFigure(const StoredSite& site);

}  // namespace freelsd
