#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {

// Returns the kept answer. Computes it only if there is none yet since the start.
void GetAlternates(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  std::optional<std::string> answer = service.alternates.Find(flight_id);
  if (!answer) answer = service.alternates.Update(flight_id);
  response.set_content(*answer, "application/json");
}

}  // namespace freelsd
