// Every URL of the service, and how a request finds its handler.
#pragma once

#include "server/body_reader.h"
#include "server/http_library.h"
#include "server/service.h"

namespace freelsd {

// The emergency listener serves recall and health only, with threads of its own.
enum class Listener { kMain, kEmergency };

// Answers the request; every failure becomes a problem+json. Does not throw.
void Serve(Service& service,
           Listener listener,
           const httplib::Request& request,
           BodyReader& body,
           httplib::Response& response);

}  // namespace freelsd
