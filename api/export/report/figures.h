// Private to report/. Figures of a site's report as HTML and SVG text.
#pragma once

#include <string>

#include "api/stored/stored.h"

namespace freelsd {

// One layer with touchdown, final, circle, north arrow and scale. Without a map: only the lines.
std::string MapFigure(const StoredSite& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer);
// Path and ground along the final; empty if the site has no approach.
std::string ProfileFigure(const StoredSite& site);

}  // namespace freelsd
