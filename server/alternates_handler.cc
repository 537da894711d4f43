#include "api/api.h"
#include "server/flight_lookup.h"
#include "server/handlers.h"

namespace freelsd {

// As it stands ready; made now only where nobody has asked for it since the start.
void GetAlternates(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  std::optional<std::string> answer = service.alternates.Find(flight_id);
  if (!answer) answer = service.alternates.Update(flight_id);
  response.set_content(*answer, "application/json");
}

}  // namespace freelsd
