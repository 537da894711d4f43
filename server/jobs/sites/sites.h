// The sites of an evaluation, as they are stored.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/api.h"
#include "server/recall/recall.h"
#include "storage/storage.h"

namespace freelsd {

// The flight at the time of an evaluation. Its request has the datum of all its altitudes.
struct EvaluatedFlight {
  FlightRequest request;
  GeoPoint origin;
  FlightContext context;
  int min_num_observations = 0;
  // Of all its frames.
  CaptureTimes times;
};

struct NewSite {
  SiteRow row;
  // Empty if the site is rejected.
  std::optional<Landing> landing;
  // Its evidence_digest.
  std::string digest;
};

// What a site is made from.
struct SiteOrigin {
  // Empty if nothing was reconstructed.
  std::string map_id;
  std::string map_digest;
  std::string inputs_digest;
};

// Sites of one map, in the order of the evaluation.
std::vector<NewSite> SitesOf(const Evaluation& evaluation,
                             const SiteOrigin& origin,
                             const EvaluatedFlight& flight);

// Keeps only the best of several accepted sites at one place, and of several with one id: landable
// before unverified, then the better score.
void DropDuplicates(std::vector<NewSite>& sites);

}  // namespace freelsd
