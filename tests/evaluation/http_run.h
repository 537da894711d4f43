// Input: the frames of a flight and a running service. Output: what it answered, as the engine in
// this process would have.
#pragma once

#include <string>

#include "tests/evaluation/engine_run.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {

// Creates a flight there, sends its photographs (without loss) and poses as batches, finishes it
// and waits. Sites and regions are filled in; poses, map and cost stay in the service. The flight
// is deleted there in the end. `url`: "http://127.0.0.1:8080". Throws std::runtime_error with the
// service's words when it refuses something or the job fails.
EngineRun RunOverHttp(const std::string& url, const Scenario& scenario, const Progress& progress);

}  // namespace freelsd
