// What a flight's report says about photographs and regions that became no site.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "api/export/report/report.h"
#include "storage/storage.h"

namespace freelsd {

// Frames that no map shows, grouped by reason, in the order of the frames. `used` holds the ids of
// those that a map shows.
std::vector<LeftOutGroup> PhotographsLeftOut(const std::vector<FrameRow>& frames,
                                             const std::set<std::string>& used);
// Regions without a site. `with_site` holds the ids of the regions that have one.
std::vector<LeftOutGroup> RegionsLeftOut(const std::vector<RegionRow>& regions,
                                         const std::set<int64_t>& with_site);

}  // namespace freelsd
