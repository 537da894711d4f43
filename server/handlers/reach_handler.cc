#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/handlers/emergency_call.h"
#include "server/handlers/handlers.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

void AnswerReach(Service& service, const EmergencyRequest& request, httplib::Response& response) {
  const SemaphoreSlot slot(service.reach_planners);
  const CompletedCall completed = CompletedFor(service, request);
  nlohmann::json answer =
      ReachFrom({service.storage, service.maps}, service.ground_patches, completed.request.request);
  completed.AddTo(answer);
  service.copy.AddTo(answer, NowUs());
  AnswerGeoJson(answer, response);
}

}  // namespace

void GetReach(Service& service, const Call& call, httplib::Response& response) {
  AnswerReach(service, EmergencyRequestOfQuery(call), response);
}

void PostReach(Service& service, const Call& call, httplib::Response& response) {
  AnswerReach(service, EmergencyRequestOf(call), response);
}

}  // namespace freelsd
