#include "server/service.h"

#include "api/api.h"

namespace freelsd {

bool Service::IsReceiving(const std::string& flight_id) const {
  const std::lock_guard lock(receiving_mutex);
  return receiving.contains(flight_id);
}

Receiving::Receiving(Service& service, const std::string& flight_id)
    : service_(service), flight_id_(flight_id) {
  if (service.is_stopping) throw ApiError("ShuttingDown", "the server is stopping");
  if (!service.uploads.try_acquire()) {
    throw ApiError("TooManyRequests", "too many uploads are read at once");
  }
  const std::lock_guard lock(service_.receiving_mutex);
  service_.receiving.insert(flight_id_);
}

Receiving::~Receiving() {
  const std::lock_guard lock(service_.receiving_mutex);
  service_.receiving.erase(service_.receiving.find(flight_id_));
  service_.uploads.release();
}

}  // namespace freelsd
