#include "server/retention.h"

#include <algorithm>
#include <set>

#include "server/stamps.h"

namespace freelsd {
namespace {

constexpr double kMicrosecondsPerDay = 86400.0 * 1e6;

// Finished, oldest first: with frames all through the engine and no job that needs them.
std::vector<FlightRow> IdleFlights(const Service& service) {
  std::set<std::string> busy;
  for (const JobRow& job : service.storage.ListUnfinishedJobs()) busy.insert(job.flight_id);
  for (const std::string& id : service.storage.FlightsWithQueuedFrames()) busy.insert(id);
  std::vector<FlightRow> flights = service.storage.ListFlights();
  std::erase_if(flights, [&](const FlightRow& flight) {
    return flight.has_retired_images || busy.contains(flight.id) || service.IsReceiving(flight.id);
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
  const bool is_too_much = max_bytes > 0 && service.storage.NumImageBytes() > max_bytes;
  for (const FlightRow& flight : IdleFlights(service)) {
    const double age_days =
        static_cast<double>(NowUs() - flight.created_at_us) / kMicrosecondsPerDay;
    const bool is_old = config.max_image_age_days > 0.0 && age_days > config.max_image_age_days;
    // One at a time for room: how much each frees is known afterwards.
    if (is_old || (is_too_much && ids.empty())) ids.push_back(flight.id);
  }
  return ids;
}

}  // namespace freelsd
