#include "server/jobs/retention.h"

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

bool IsOld(const Config& config, int64_t time_us) {
  const double age_days = static_cast<double>(NowUs() - time_us) / kMicrosecondsPerDay;
  return config.max_image_age_days > 0.0 && age_days > config.max_image_age_days;
}

bool IsTooMuch(const Service& service) {
  const uint64_t max_bytes = service.config.max_stored_image_bytes;
  return max_bytes > 0 && service.storage.images.NumBytes() > max_bytes;
}

}  // namespace

std::vector<std::string> FlightsToRetire(const Service& service) {
  const Config& config = service.config;
  std::vector<std::string> ids;
  if (config.max_image_age_days <= 0.0 && config.max_stored_image_bytes == 0) return ids;
  const bool is_too_much = IsTooMuch(service);
  for (const FlightRow& flight : IdleFlights(service)) {
    // For size, one flight at a time: the space that it frees is known only afterwards.
    const bool is_next = is_too_much && ids.empty();
    if (IsOld(config, flight.created_at_us) || is_next) ids.push_back(flight.id);
  }
  return ids;
}

std::vector<std::string> FlightsToRetirePicturesOf(const Service& service) {
  const Config& config = service.config;
  std::vector<std::string> ids;
  if (config.max_image_age_days <= 0.0 && config.max_stored_image_bytes == 0) return ids;
  // The photographs of a flight are larger than its picture, and nobody looks at them again.
  const bool is_too_much = IsTooMuch(service) && FlightsToRetire(service).empty();
  for (const std::string& id : service.storage.maps.ListFlightsWithPhotoTiles()) {
    const std::vector<FlightMapRow> maps = service.storage.maps.ListOf(id);
    const bool is_old = !maps.empty() && IsOld(config, maps.front().updated_at_us);
    // Those after it are younger.
    if (!is_old && !(is_too_much && ids.empty())) break;
    ids.push_back(id);
  }
  return ids;
}

}  // namespace freelsd
