// Decides which of several flights' sites on the same ground supersedes the others: the site whose
// ground was photographed last, in whatever order the flights arrived. The caller holds
// Service::sites_mutex.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

// How a site relates to other sites on the same ground.
struct Standing {
  // Ids of sites on the same ground that were photographed earlier.
  std::vector<std::string> supersedes;
  // Id of the site on the same ground that was photographed last, if later than this one.
  std::optional<std::string> superseded_by;
};
// The standing of a site among the stored sites of other flights.
Standing StandingOf(const Storage& storage, const SiteRow& site);

// Deletes a site. Sites that it superseded are recalled again, or superseded by another site. False
// if there is no such site.
bool ForgetSite(Storage& storage, const std::string& site_id);

}  // namespace freelsd
