#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "server/handlers/emergency_call.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

void AnswerReach(Service& service,
                 const Call& call,
                 const EmergencyRequest& request,
                 httplib::Response& response) {
  const StopIfUnwanted stop_if_unwanted = WantedBy(service, call);
  const LongPlace place(service.long_queues.reach, stop_if_unwanted);
  const CompletedCall completed = CompletedFor(service, request);
  nlohmann::json answer = ReachFrom({service.storage, service.maps, stop_if_unwanted},
                                    service.ground_patches,
                                    completed.request.request);
  completed.AddTo(answer);
  service.copy.AddTo(answer, NowUs());
  AnswerGeoJson(answer, response);
}

}  // namespace

void GetReach(Service& service, const Call& call, httplib::Response& response) {
  AnswerReach(service, call, EmergencyRequestOfQuery(call), response);
}

void PostReach(Service& service, const Call& call, httplib::Response& response) {
  AnswerReach(service, call, EmergencyRequestOf(call), response);
}

}  // namespace freelsd
