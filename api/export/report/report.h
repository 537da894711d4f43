// A one-page report of a site, for people.
#pragma once

#include <string>

#include "api/stored/stored.h"

namespace freelsd {

// Self-contained HTML that loads no other file: verdict, map with layers, profile, numbers.
// `site_map` may be empty.
std::string SiteReport(const StoredSite& site,
                       const SiteMap& site_map,
                       const LocalFrame& local_frame);

}  // namespace freelsd
