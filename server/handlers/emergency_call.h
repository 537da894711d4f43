// Calls with the parameters of an emergency request: emergency recall, reach.
#pragma once

#include <nlohmann/json.hpp>

#include "server/http/http.h"
#include "server/jobs/jobs.h"
#include "server/recall/recall.h"

namespace freelsd {

// From the query. Throws ApiError with the names of query parameters.
EmergencyRequest EmergencyRequestOfQuery(const Call& call);
// From the JSON body; without a body, from the query. Throws ApiError.
EmergencyRequest EmergencyRequestOf(const Call& call);

// A request, completed from the flight that it names.
struct CompletedCall {
  CompletedRequest request;
  bool is_flight_unread = false;

  // Adds what was taken from the flight, or a warning that its data cannot be read.
  void AddTo(nlohmann::json& answer) const;
};

// Throws ApiError NoSuchFlight.
CompletedCall CompletedFor(const Service& service, const EmergencyRequest& request);

}  // namespace freelsd
