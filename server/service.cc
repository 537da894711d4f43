#include "server/service.h"

#include "api/api.h"

namespace freelsd {
namespace {

void Mark(Service& service, const std::string& flight_id) {
  const std::lock_guard lock(service.receiving_mutex);
  service.receiving.insert(flight_id);
}

void Unmark(Service& service, const std::string& flight_id) {
  const std::lock_guard lock(service.receiving_mutex);
  service.receiving.erase(service.receiving.find(flight_id));
}

void RefuseWhenStopping(const Service& service) {
  if (service.is_stopping) throw ApiError("ShuttingDown", "the server is stopping");
}

}  // namespace

bool Service::IsReceiving(const std::string& flight_id) const {
  const std::lock_guard lock(receiving_mutex);
  return receiving.contains(flight_id);
}

Receiving::Receiving(Service& service, const std::string& flight_id)
    : service_(service), flight_id_(flight_id) {
  RefuseWhenStopping(service_);
  if (!service_.uploads.try_acquire()) {
    throw ApiError("TooManyRequests", "too many uploads are read at once");
  }
  Mark(service_, flight_id_);
}

Receiving::~Receiving() {
  Unmark(service_, flight_id_);
  service_.uploads.release();
}

Streaming::Streaming(Service& service, const std::string& flight_id)
    : service_(service), flight_id_(flight_id) {
  RefuseWhenStopping(service_);
  if (!service_.streams.try_acquire()) {
    throw ApiError("TooManyRequests", "too many streams are read at once");
  }
  Mark(service_, flight_id_);
}

Streaming::~Streaming() {
  Unmark(service_, flight_id_);
  service_.streams.release();
}

}  // namespace freelsd
