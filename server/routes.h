// The table of all URLs, and the dispatch of a request to its handler.
#pragma once

#include "server/http/http.h"
#include "server/work/work.h"

namespace freelsd {

// The emergency listener serves recall and health only, with its own threads.
enum class Listener { kMain, kEmergency };

// Answers the request. Every failure becomes a problem+json answer. Does not throw. Thread-safe.
void Serve(Service& service,
           Listener listener,
           const httplib::Request& request,
           BodyReader& body,
           httplib::Response& response);

}  // namespace freelsd
