// Input: the frames of a flight. Output: its sites, stored in a running service.
#pragma once

#include <string>

#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// Creates a flight there, sends its photographs (without loss) and poses as batches, finishes it
// and waits. The flight is deleted there in the end, its sites and map stay. `url`:
// "http://127.0.0.1:8080". Throws std::runtime_error with the service's words when it refuses
// something or the job fails.
void StoreOverHttp(const std::string& url, const Scenario& scenario);

}  // namespace freelsd
