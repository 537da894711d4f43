// Alternates: for each flight that sends data, a list of the best sites in reach from its latest
// pose. A thread keeps the lists up to date, so that a request finds its answer ready.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace freelsd {

class EventLog;
class MapCache;
class Storage;

// Thread-safe.
class Alternates {
 public:
  // All three must live until Stop returns.
  Alternates(const Storage& storage, MapCache& maps, EventLog& events)
      : storage_(storage), maps_(maps), events_(events) {}
  ~Alternates();
  Alternates(const Alternates&) = delete;
  Alternates& operator=(const Alternates&) = delete;

  void Start();
  void Stop();
  // Call it when the flight's pose or wind changed. Never waits. Flights take turns.
  void Wake(const std::string& flight_id);
  // Call it when stored sites changed: lists of flights that were woken lately are computed anew,
  // others are dropped and computed when they are asked for.
  void WakeAll();
  // The latest answer as JSON text; nothing if there is none yet.
  std::optional<std::string> Find(const std::string& flight_id) const;
  void Forget(const std::string& flight_id);

  // Computes the answer now, keeps it and publishes an event. Empty if there is no such flight.
  std::string Update(const std::string& flight_id);

 private:
  using Clock = std::chrono::steady_clock;

  // The caller holds mutex_.
  void Enqueue(const std::string& flight_id);
  void Run();

  const Storage& storage_;
  MapCache& maps_;
  EventLog& events_;
  // Guards all members below but thread_.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // In order of waking; each flight at most once.
  std::deque<std::string> due_;
  std::map<std::string, Clock::time_point> woken_at_;
  std::map<std::string, Clock::time_point> updated_at_;
  std::map<std::string, std::string> answers_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace freelsd
