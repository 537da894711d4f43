// The table of all URLs; passes each request to its handler.
#pragma once

#include "server/http/http.h"
#include "server/jobs/jobs.h"

namespace freelsd {

// The emergency listener has its own threads. It serves only emergency recall and /healthz.
enum class Listener { kMain, kEmergency };

// Answers the request, every failure with problem+json, and does not throw. Thread-safe.
void Serve(Service& service,
           Listener listener,
           const httplib::Request& request,
           BodyReader& body,
           httplib::Response& response);

}  // namespace freelsd
