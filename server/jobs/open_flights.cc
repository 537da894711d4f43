#include "server/jobs/open_flights.h"

#include <algorithm>
#include <utility>

namespace freelsd {
namespace {

// The number of flights that stay in memory without work, and the time that any flight stays. A
// slow stream is idle between frames, and rebuilding its session costs as much as all its frames.
constexpr size_t kMaxNumIdle = 4;
constexpr std::chrono::seconds kMinIdleTime{120};

}  // namespace

std::set<std::string> OpenFlights::Ids() const {
  const std::lock_guard lock(mutex_);
  std::set<std::string> ids;
  for (const auto& [flight_id, open] : open_) ids.insert(flight_id);
  return ids;
}

OpenFlights::SessionPointer OpenFlights::Find(const std::string& flight_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(flight_id);
  return found == open_.end() ? nullptr : found->second.session;
}

bool OpenFlights::MayOpen(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  if (open_.contains(flight_id)) return true;
  const auto place = std::find(waiting_.begin(), waiting_.end(), flight_id);
  const auto num_before = static_cast<size_t>(place - waiting_.begin());
  if (open_.size() + num_before < max_num_open_) return true;
  if (place == waiting_.end()) waiting_.push_back(flight_id);
  return false;
}

void OpenFlights::Open(const std::string& flight_id, SessionPointer session) {
  const std::lock_guard lock(mutex_);
  open_[flight_id].session = std::move(session);
  std::erase(waiting_, flight_id);
}

void OpenFlights::Touch(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  const auto open = open_.find(flight_id);
  if (open != open_.end()) open->second.used_at = std::chrono::steady_clock::now();
}

bool OpenFlights::IsParked(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  const auto parked = parked_at_.find(flight_id);
  if (parked == parked_at_.end()) return false;
  if (!storage_.frames.Next(flight_id, parked->second)) return true;
  parked_at_.erase(parked);
  return false;
}

std::vector<std::pair<OpenFlights::Time, std::string>> OpenFlights::Idle(
    const std::set<std::string>& busy_flights,
    const std::set<std::string>& flights_with_jobs) const {
  const Time now = std::chrono::steady_clock::now();
  std::vector<std::pair<Time, std::string>> idle;
  for (const auto& [flight_id, open] : open_) {
    const bool is_stalled = now - open.used_at > kMinIdleTime;
    if (!is_stalled && busy_flights.contains(flight_id)) continue;
    if (!flights_with_jobs.contains(flight_id)) idle.emplace_back(open.used_at, flight_id);
  }
  std::sort(idle.begin(), idle.end());
  return idle;
}

std::vector<std::string> OpenFlights::CloseIdle(const std::set<std::string>& busy_flights,
                                                const std::set<std::string>& flights_with_jobs) {
  const Time now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  std::erase_if(waiting_, [&](const std::string& id) { return !busy_flights.contains(id); });
  const auto idle = Idle(busy_flights, flights_with_jobs);
  const bool is_any_waiting =
      std::any_of(busy_flights.begin(), busy_flights.end(), [this](const std::string& flight_id) {
        return !open_.contains(flight_id);
      });
  std::vector<std::string> closed;
  for (size_t i = 0; i < idle.size(); ++i) {
    const auto& [used_at, flight_id] = idle[i];
    const bool is_surplus = idle.size() - i > kMaxNumIdle && now - used_at > kMinIdleTime;
    const bool is_in_the_way = is_any_waiting && IsFull();
    if (!is_surplus && !is_in_the_way && storage_.flights.Find(flight_id)) continue;
    Park(flight_id);
    closed.push_back(flight_id);
  }
  return closed;
}

void OpenFlights::Close(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  std::erase(waiting_, flight_id);
  Park(flight_id);
}

void OpenFlights::Park(const std::string& flight_id) {
  const auto open = open_.find(flight_id);
  if (open == open_.end()) return;
  parked_at_[flight_id] = open->second.session->cursor();
  open_.erase(open);
}

}  // namespace freelsd
