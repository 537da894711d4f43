// The backend's part of a flight: evaluates regions and stores their sites.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "server/jobs/flight_session.h"
#include "server/jobs/service.h"

namespace freelsd {

enum class EvaluationScope {
  kBest,        // the best few regions, while frames arrive
  kEveryGraded  // all regions with a grade above 0; sites of other regions are removed
};

struct EvaluationCount {
  size_t num_sites = 0;
  // Of the last frame that the engine had got.
  int64_t through_sequence = 0;
};

// Returns the number of stored sites. Throws what the engine throws, and
// std::runtime_error("cancelled") if `progress` returned false. Stores nothing if the flight was
// deleted in the meantime. Call it only from the backend thread.
EvaluationCount EvaluateFlight(Service& service,
                               const std::string& flight_id,
                               FlightSession& session,
                               EvaluationScope scope,
                               const Progress& progress);

// The evidence_digest of each site that EvaluateFlight would store for kEveryGraded, by site id.
// Stores nothing. Throws as EvaluateFlight.
std::map<std::string, std::string> EvidenceDigests(Service& service,
                                                   const std::string& flight_id,
                                                   FlightSession& session,
                                                   const Progress& progress);

}  // namespace freelsd
