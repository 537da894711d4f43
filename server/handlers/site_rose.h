// The wind rose of a stored site.
#pragma once

#include <memory>

#include "server/jobs/jobs.h"

namespace freelsd {

struct SiteRose {
  // On the map that the rose was planned on.
  std::shared_ptr<const KeptSite> site;
  WindRose rose;
};

// Plans for the obstacles that are in force now.
SiteRose PlanSiteRose(Service& service,
                      const std::shared_ptr<const KeptSite>& stored,
                      const Aircraft& aircraft,
                      const WindRoseOptions& options,
                      const StopIfUnwanted& stop_if_unwanted);

}  // namespace freelsd
