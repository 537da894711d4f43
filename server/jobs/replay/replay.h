// Repeats the evaluation of a stored flight, to prove what its sites were made from.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/jobs/flight_session.h"
#include "server/jobs/service.h"

namespace freelsd {

// Gives the stored photographs of the flight's last finish to a new engine and evaluates them.
// Returns {sites: [{site_id, stored, replayed, is_equal}], num_equal}: the digests of the stored
// sites and of the new ones, null where one is missing. Nothing is changed. Throws what the engine
// throws; std::runtime_error if no finish is done, if an image is gone, or with "cancelled" if
// `progress` returned false. Call it only from the backend thread.
nlohmann::json ReplayFlight(Service& service,
                            const std::string& flight_id,
                            const GroundModels& ground_models,
                            const Progress& progress);

}  // namespace freelsd
