#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/handlers/emergency_call.h"
#include "server/handlers/emergency_landing.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// True for parameters that select the form of the answer. They are not part of the request.
bool IsOfForm(const std::string& parameter) {
  return parameter == "f" || parameter == "home_altitude_m" || parameter == "firmware";
}

// The query parameters as a JSON object, so that GET and POST share one parser.
nlohmann::json QueryObject(const Call& call) {
  nlohmann::json object = nlohmann::json::object();
  for (const auto& [name, value] : call.request.params) {
    if (IsOfForm(name)) continue;
    if (name == "altitude_datum" || name == "aircraft" || name == "flight") {
      object[name] = *call.Query(name);
    } else if (name == "limit") {
      object[name] = *call.QueryInteger(name);
    } else {
      object[name] = *call.QueryNumber(name);
    }
  }
  return object;
}

std::string FormatOf(const Call& call) {
  std::string format = call.Query("f").value_or("json");
  if (format == "json" || format == "plan" || format == "waypoints") return format;
  const std::string detail = "f: must be json, plan or waypoints";
  throw ApiError("InvalidQuery", detail, {{"f", detail}});
}

void AnswerEmergency(Service& service,
                     const Call& call,
                     const EmergencyRequest& request,
                     httplib::Response& response) {
  const std::string format = FormatOf(call);
  const ExportOptions options = ExportOptionsOf(call);
  const CompletedCall completed = CompletedFor(service, request);
  nlohmann::json answer = RecallSites({service.storage, service.maps}, completed.request.request);
  completed.AddTo(answer);
  service.copy.AddTo(answer, NowUs());
  if (format != "json") return AnswerLanding(service, answer, format, options, response);
  response.set_content(answer.dump(), "application/json");
}

}  // namespace

// Errors name the query parameter instead of a JSON pointer into a body.
EmergencyRequest EmergencyRequestOfQuery(const Call& call) {
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

EmergencyRequest EmergencyRequestOf(const Call& call) {
  const std::string body = call.body.ReadAll(kLimits.max_emergency_bytes);
  if (body.empty()) return EmergencyRequestOfQuery(call);
  if (!QueryObject(call).empty()) {
    throw ApiError("InvalidQuery", "a request has either a body or query parameters, not both");
  }
  return ParseEmergencyRequest(ParseJson(body, kLimits.max_emergency_bytes));
}

CompletedCall CompletedFor(const Service& service, const EmergencyRequest& request) {
  CompletedCall completed{{request, nullptr}};
  try {
    if (request.flight_id) completed.request = CompletedFromFlight(service.storage, request);
  } catch (const StorageError& error) {
    // Flights have no second copy. If the flight's row is damaged, the request is answered without
    // the flight's data.
    spdlog::error("emergency recall for a flight: {}", error.what());
    completed.is_flight_unread = true;
  }
  return completed;
}

void CompletedCall::AddTo(nlohmann::json& answer) const {
  if (!request.taken.is_null()) answer["taken_from_flight"] = request.taken;
  if (is_flight_unread) answer["warnings"].push_back("the flight's data cannot be read");
}

void GetEmergency(Service& service, const Call& call, httplib::Response& response) {
  AnswerEmergency(service, call, EmergencyRequestOfQuery(call), response);
}

// Takes the request as JSON in the body. A POST without a body may use the query instead.
void PostEmergency(Service& service, const Call& call, httplib::Response& response) {
  AnswerEmergency(service, call, EmergencyRequestOf(call), response);
}

}  // namespace freelsd
