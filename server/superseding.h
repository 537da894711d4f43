// Of sites on the same ground, seen by several flights, which one speaks: the one whose ground was
// photographed last, in whatever order the flights came. The caller holds Service::sites_mutex.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "storage/storage.h"

namespace freelsd {

struct Standing {
  // Seen before it.
  std::vector<std::string> supersedes;
  // The newest of those seen after it.
  std::optional<std::string> superseded_by;
};
// Of a site among the stored sites of other flights.
Standing StandingOf(const Storage& storage, const SiteRow& site);

// Deletes a site; those that it superseded stand as if it had never been. False where there is
// none.
bool ForgetSite(Storage& storage, const std::string& site_id);

}  // namespace freelsd
