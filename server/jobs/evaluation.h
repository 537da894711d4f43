// The backend's part of a flight: evaluates regions and stores their sites.
#pragma once

#include <functional>
#include <string>

#include "server/jobs/flight_session.h"
#include "server/jobs/service.h"

namespace freelsd {

enum class EvaluationScope {
  kBest,        // the best few regions, while frames arrive
  kEveryGraded  // all regions with a grade above 0; sites of other regions are removed
};

// Returns the number of stored sites. Throws what the engine throws, and
// std::runtime_error("cancelled") if `progress` returned false. Stores nothing if the flight was
// deleted in the meantime. Call it only from the backend thread.
size_t EvaluateFlight(Service& service,
                      const std::string& flight_id,
                      FlightSession& session,
                      EvaluationScope scope,
                      const Progress& progress);

}  // namespace freelsd
