#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {
namespace {

std::optional<size_t> ParseLimit(const Call& call) {
  constexpr auto kMax = static_cast<int64_t>(kLimits.answer.max_num_alternates);
  const std::optional<int64_t> limit = call.QueryInteger("limit");
  if (!limit) return std::nullopt;
  if (*limit < 1 || *limit > kMax) {
    const std::string rule =
        "must be a whole number, 1 to " + std::to_string(kLimits.answer.max_num_alternates);
    throw ApiError("InvalidValue", "limit: " + rule, {{"limit", rule}});
  }
  return static_cast<size_t>(*limit);
}

std::string WithCopy(const Service& service, const std::string& text) {
  nlohmann::json answer = nlohmann::json::parse(text);
  service.copy.AddTo(answer, NowUs());
  return answer.dump();
}

}  // namespace

void GetAlternates(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  const std::string answer = service.alternates.Answer(flight_id, ParseLimit(call));
  if (answer.empty()) throw ApiError("NoSuchFlight", "there is no such flight");
  response.set_content(service.copy.IsThere() ? WithCopy(service, answer) : answer,
                       "application/json");
}

}  // namespace freelsd
