// Private to report/. Figures of reports as HTML and SVG text.
#pragma once

#include <string>
#include <vector>

#include "api/export/report/report.h"

namespace freelsd {

// One layer with touchdown, final, circle, north arrow and scale. If the map is empty, the figure
// has no layer.
std::string MapFigure(const StoredSite& site,
                      const SiteMap& site_map,
                      const LocalFrame& local_frame,
                      const std::string& layer);
// Heights of path and terrain along the final; empty if the site has no approach.
std::string ProfileFigure(const StoredSite& site);

// One of the report's maps with hazard, and the numbered sites on it. `title` is plain text.
std::string FlightMapFigure(const FlightReport& report,
                            const ReportedMap& map,
                            const std::string& title);
// The landing on the photograph, or on the hazard where there is none; empty without a picture.
std::string CutOutFigure(const ReportedSite& site, const LocalFrame& local_frame);
// How many photographs see each place; empty if that was not computed.
std::string CoverageFigure(const ReportedMap& map);

// The winds in which one can land. A cell is filled, striped or crossed: verdicts differ without
// colour too.
std::string RoseFigure(const WindRose& rose);
// The patterns of all roses of a page, once.
std::string RosePatterns();

}  // namespace freelsd
