#include "server/intake/state.h"

#include "api/api.h"

namespace freelsd {
namespace {

void Mark(Intake& intake, const std::string& flight_id) {
  const std::lock_guard lock(intake.receiving_mutex);
  intake.receiving.insert(flight_id);
}

void Unmark(Intake& intake, const std::string& flight_id) {
  const std::lock_guard lock(intake.receiving_mutex);
  intake.receiving.erase(intake.receiving.find(flight_id));
}

void RefuseWhenStopping(const Intake& intake) {
  if (intake.is_stopping) throw ApiError("ShuttingDown", "the server is stopping");
}

}  // namespace

bool Intake::IsReceiving(const std::string& flight_id) const {
  const std::lock_guard lock(receiving_mutex);
  return receiving.contains(flight_id);
}

Receiving::Receiving(Intake& intake, const std::string& flight_id)
    : intake_(intake), flight_id_(flight_id) {
  RefuseWhenStopping(intake_);
  if (!intake_.uploads.try_acquire()) {
    throw ApiError("TooManyRequests", "too many uploads at the same time");
  }
  Mark(intake_, flight_id_);
}

Receiving::~Receiving() {
  Unmark(intake_, flight_id_);
  intake_.uploads.release();
}

Streaming::Streaming(Intake& intake, const std::string& flight_id)
    : intake_(intake), flight_id_(flight_id) {
  RefuseWhenStopping(intake_);
  if (!intake_.streams.try_acquire()) {
    throw ApiError("TooManyRequests", "too many streams at the same time");
  }
  Mark(intake_, flight_id_);
}

Streaming::~Streaming() {
  Unmark(intake_, flight_id_);
  intake_.streams.release();
}

}  // namespace freelsd
