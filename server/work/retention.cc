#include "server/work/retention.h"

#include <algorithm>
#include <set>

#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr double kMicrosecondsPerDay = 86400.0 * 1e6;

// Flights whose frames are all processed and that no job needs, oldest first.
std::vector<FlightRow> IdleFlights(const Service& service) {
  std::set<std::string> busy;
  for (const JobRow& job : service.storage.jobs.ListUnfinished()) busy.insert(job.flight_id);
  for (const std::string& id : service.storage.flights.ListWithQueuedFrames()) busy.insert(id);
  std::vector<FlightRow> flights = service.storage.flights.List();
  std::erase_if(flights, [&](const FlightRow& flight) {
    return flight.has_retired_images || busy.contains(flight.id) ||
           service.intake.IsReceiving(flight.id);
  });
  std::reverse(flights.begin(), flights.end());
  return flights;
}

}  // namespace

std::vector<std::string> FlightsToRetire(const Service& service) {
  const Config& config = service.config;
  std::vector<std::string> ids;
  if (config.max_image_age_days <= 0.0 && config.max_stored_image_bytes == 0) return ids;
  const uint64_t max_bytes = config.max_stored_image_bytes;
  const bool is_too_much = max_bytes > 0 && service.storage.images.NumBytes() > max_bytes;
  for (const FlightRow& flight : IdleFlights(service)) {
    const double age_days =
        static_cast<double>(NowUs() - flight.created_at_us) / kMicrosecondsPerDay;
    const bool is_old = config.max_image_age_days > 0.0 && age_days > config.max_image_age_days;
    // For size, one flight at a time: the space that it frees is known only afterwards.
    if (is_old || (is_too_much && ids.empty())) ids.push_back(flight.id);
  }
  return ids;
}

}  // namespace freelsd
