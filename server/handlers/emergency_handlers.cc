#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/emergency_landing.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

// The form of the answer, not the request itself.
bool IsOfForm(const std::string& parameter) {
  return parameter == "f" || parameter == "home_altitude_m" || parameter == "firmware";
}

// The query parameters as a JSON object, so that GET and POST share one parser.
nlohmann::json QueryObject(const Call& call) {
  nlohmann::json object = nlohmann::json::object();
  for (const auto& [name, value] : call.request.params) {
    if (IsOfForm(name)) continue;
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

std::string FormatOf(const Call& call) {
  std::string format = call.Query("f").value_or("json");
  if (format == "json" || format == "plan" || format == "waypoints") return format;
  const std::string detail = "f: must be json, plan or waypoints";
  throw ApiError("InvalidQuery", detail, {{"f", detail}});
}

void Answer(Service& service,
            const Call& call,
            const EmergencyRequest& request,
            httplib::Response& response) {
  const std::string format = FormatOf(call);
  const ExportOptions options = ExportOptionsOf(call);
  const nlohmann::json answer = RecallSites({service.storage, service.maps}, request);
  if (format != "json") return AnswerLanding(service, answer, format, options, response);
  response.set_content(answer.dump(), "application/json");
}

}  // namespace

void GetEmergency(Service& service, const Call& call, httplib::Response& response) {
  Answer(service, call, ParseQuery(call), response);
}

// Takes the request as JSON in the body. A POST without a body may use the query instead.
void PostEmergency(Service& service, const Call& call, httplib::Response& response) {
  const std::string body = call.body.ReadAll(kLimits.max_emergency_bytes);
  if (!body.empty() && !QueryObject(call).empty()) {
    throw ApiError("InvalidQuery", "a request has either a body or query parameters, not both");
  }
  const EmergencyRequest request =
      body.empty() ? ParseQuery(call)
                   : ParseEmergencyRequest(ParseJson(body, kLimits.max_emergency_bytes));
  Answer(service, call, request, response);
}

}  // namespace freelsd
