// The backend's part of a flight: evaluates regions and stores their sites.
#pragma once

#include <functional>
#include <string>

#include "server/flight_session.h"
#include "server/service.h"

namespace freelsd {

enum class EvaluationScope {
  kBest,        // the best few, while frames stream in
  kEveryGraded  // all with a grade above 0; sites of other regions are removed
};

// Number of sites that were stored. Throws what the engine throws; std::runtime_error("cancelled")
// when `progress` answered false. Stores nothing where the flight is gone by the end.
size_t EvaluateFlight(Service& service,
                      const std::string& flight_id,
                      FlightSession& session,
                      EvaluationScope scope,
                      const Progress& progress);

}  // namespace freelsd
