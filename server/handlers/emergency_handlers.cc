#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// The query parameters as a JSON object, so that GET and POST share one parser.
nlohmann::json QueryObject(const Call& call) {
  nlohmann::json object = nlohmann::json::object();
  for (const auto& [name, value] : call.request.params) {
    if (name == "altitude_datum" || name == "aircraft" || name == "flight") {
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

void AnswerEmergency(Service& service,
                     const EmergencyRequest& request,
                     httplib::Response& response) {
  const StoredSites stored{service.storage, service.maps};
  CompletedRequest completed{request, nullptr};
  bool is_flight_unread = false;
  try {
    if (request.flight_id) completed = CompletedFromFlight(service.storage, request);
  } catch (const StorageError& error) {
    // Sites have a second copy, flights have none: a damaged flight must not cost the answer.
    spdlog::error("emergency recall for a flight: {}", error.what());
    is_flight_unread = true;
  }
  nlohmann::json answer = RecallSites(stored, completed.request);
  if (!completed.taken.is_null()) answer["taken_from_flight"] = std::move(completed.taken);
  if (is_flight_unread) answer["warnings"].push_back("the flight's data cannot be read");
  response.set_content(answer.dump(), "application/json");
}

}  // namespace

void GetEmergency(Service& service, const Call& call, httplib::Response& response) {
  AnswerEmergency(service, ParseQuery(call), response);
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
  AnswerEmergency(service, request, response);
}

}  // namespace freelsd
