#include "server/recall/alternates.h"

#include <algorithm>
#include <chrono>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/stored/stored.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/recall/recall_sites.h"

namespace freelsd {
namespace {

constexpr size_t kNumAlternates = 3;
// Of one flight: its poses may arrive 50 times a second.
constexpr std::chrono::milliseconds kMinPeriod{100};
// A flight that was not woken for that long has landed, or only asked.
constexpr std::chrono::seconds kLiveFor{60};

// The later of the telemetry's pose and the last frame's pose; nothing if neither is known.
std::optional<FrameMeta> LatestPose(const Storage& storage, const std::string& flight_id) {
  FrameMeta latest = LatestTelemetry(storage, flight_id);
  const std::optional<FrameRow> frame = storage.frames.Last(flight_id);
  if (frame) {
    const FrameMeta meta =
        ParseStoredPose(frame->resolved_json, frame->meta_json, frame->tags_json);
    const bool is_later =
        !latest.position || meta.timestamp_us.value_or(0) > latest.timestamp_us.value_or(0);
    if (meta.position && is_later) latest = Merged(meta, latest);
  }
  if (!latest.position) return std::nullopt;
  return latest;
}

nlohmann::json AlternatesOf(const StoredSites& stored, const FlightRow& flight) {
  const std::optional<FrameMeta> pose = LatestPose(stored.storage, flight.id);
  nlohmann::json answer{{"flight_id", flight.id}, {"sites", nlohmann::json::array()}};
  if (!pose) {
    answer["warnings"] = {"no pose of the flight is known yet"};
    return answer;
  }
  const FlightRequest flight_request = ParseFlightRequest(flight.request_json);
  EmergencyRequest request;
  request.place = *pose->position;
  request.altitude_datum = AltitudeDatumOf(flight);
  request.flight_id = flight.id;
  request.wind_in_world = pose->wind_in_world;
  // No heading is given, so recall assumes the worst turn: attitude does not show the course.
  request.aircraft = flight_request.aircraft;
  request.limit = kNumAlternates;
  answer.update(RecallSites(stored, request));
  answer["pose"] = {{"latitude_deg", request.place.latitude_deg},
                    {"longitude_deg", request.place.longitude_deg},
                    {"altitude_m", request.place.altitude_m}};
  answer["pose"]["altitude_datum"] = *request.altitude_datum;
  if (pose->timestamp_us) answer["pose"]["timestamp_us"] = *pose->timestamp_us;
  if (const auto& wind = request.wind_in_world) {
    answer["wind"] = {{"east_mps", wind->x()}, {"north_mps", wind->y()}};
  }
  answer["updated_at"] = Rfc3339(NowUs());
  return answer;
}

}  // namespace

Alternates::~Alternates() { Stop(); }

void Alternates::Start() {
  thread_ = std::thread([this] { Run(); });
}

void Alternates::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Alternates::Enqueue(const std::string& flight_id) {
  if (std::find(due_.begin(), due_.end(), flight_id) == due_.end()) due_.push_back(flight_id);
}

void Alternates::Wake(const std::string& flight_id) {
  {
    const std::lock_guard lock(mutex_);
    woken_at_[flight_id] = Clock::now();
    Enqueue(flight_id);
  }
  changed_.notify_all();
}

void Alternates::WakeAll() {
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    std::erase_if(woken_at_, [&](const auto& woken) { return now - woken.second > kLiveFor; });
    std::erase_if(answers_, [&](const auto& kept) { return !woken_at_.contains(kept.first); });
    std::erase_if(updated_at_, [&](const auto& kept) { return !woken_at_.contains(kept.first); });
    for (const auto& [flight_id, woken_at] : woken_at_) Enqueue(flight_id);
  }
  changed_.notify_all();
}

std::optional<std::string> Alternates::Find(const std::string& flight_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = answers_.find(flight_id);
  if (found == answers_.end()) return std::nullopt;
  return found->second;
}

void Alternates::Forget(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  answers_.erase(flight_id);
  woken_at_.erase(flight_id);
  updated_at_.erase(flight_id);
  std::erase(due_, flight_id);
}

std::string Alternates::Update(const std::string& flight_id) {
  const std::optional<FlightRow> flight = storage_.flights.Find(flight_id);
  if (!flight) return {};
  std::string answer = AlternatesOf({storage_, maps_}, *flight).dump();
  events_.Publish("alternates", flight_id, answer);
  const std::lock_guard lock(mutex_);
  answers_[flight_id] = answer;
  return answer;
}

void Alternates::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_stopping_ || !due_.empty(); });
    if (is_stopping_) return;
    // The flight that waits longest. All have the same period, so none behind it is due earlier.
    const std::string flight_id = due_.front();
    if (const auto updated = updated_at_.find(flight_id); updated != updated_at_.end()) {
      const Clock::time_point next = updated->second + kMinPeriod;
      if (Clock::now() < next) {
        changed_.wait_until(lock, next, [this] { return is_stopping_; });
        continue;
      }
    }
    due_.pop_front();
    updated_at_[flight_id] = Clock::now();
    lock.unlock();
    try {
      Update(flight_id);
    } catch (const std::exception& error) {
      // The next pose triggers a retry.
      spdlog::error("alternates of flight {}: {}", flight_id, error.what());
    }
    lock.lock();
  }
}

}  // namespace freelsd
