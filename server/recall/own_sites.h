// The sites of an experiment: a flight whose memory is "none". Recall finds them for this flight
// alone.
#pragma once

#include "server/recall/emergency_request.h"
#include "storage/storage.h"

namespace freelsd {

inline constexpr const char* kExperimentWarning =
    "Of an experiment (memory: none): its options may not be those that were tested, and no other "
    "flight recalls it.";

// As it is stored: a site of an experiment has no recall data, and its feature says so.
SiteRow AsRemembered(SiteRow site, const FlightMemory& memory);

// Whether the request finds the site only because both are of the same experiment.
bool IsOwnExperiment(const EmergencyRequest& request, const RecallRow& site);
// Empty unless the request is of an experiment.
SharedRows<RecallRow> OwnSites(const Storage& storage, const EmergencyRequest& request);
// Bounds that hold for these sites too.
RecallBounds WithSites(RecallBounds bounds, const SharedRows<RecallRow>& sites);

}  // namespace freelsd
