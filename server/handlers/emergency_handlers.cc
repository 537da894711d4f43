#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// The query parameters as a JSON object, so that GET and POST share one parser.
nlohmann::json QueryObject(const Call& call) {
  nlohmann::json object = nlohmann::json::object();
  for (const auto& [name, value] : call.request.params) {
    if (name == "altitude_datum" || name == "aircraft") {
      object[name] = *call.Query(name);
    } else {
      object[name] = *call.QueryNumber(name);
    }
  }
  return object;
}

// Errors name the query parameter instead of a JSON pointer into a body.
EmergencyRequest ParseQuery(const Call& call) {
  try {
    return ParseEmergencyRequest(QueryObject(call));
  } catch (const ApiError& error) {
    std::vector<FieldError> errors = error.errors();
    for (FieldError& each : errors) {
      if (each.pointer.starts_with("/")) each.pointer.erase(0, 1);
    }
    throw ApiError(error.code(), error.what(), errors);
  }
}

}  // namespace

void GetEmergency(Service& service, const Call& call, httplib::Response& response) {
  response.set_content(RecallSites({service.storage, service.maps}, ParseQuery(call)).dump(),
                       "application/json");
}

// Takes the request as JSON in the body. A POST without a body may use the query instead.
void PostEmergency(Service& service, const Call& call, httplib::Response& response) {
  const std::string body = call.body.ReadAll(kLimits.max_emergency_bytes);
  if (!body.empty() && !call.request.params.empty()) {
    throw ApiError("InvalidQuery", "a request has either a body or query parameters, not both");
  }
  const EmergencyRequest request =
      body.empty() ? ParseQuery(call)
                   : ParseEmergencyRequest(ParseJson(body, kLimits.max_emergency_bytes));
  response.set_content(RecallSites({service.storage, service.maps}, request).dump(),
                       "application/json");
}

}  // namespace freelsd
