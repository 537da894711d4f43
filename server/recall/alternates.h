// Alternates: for each flight that sends data, a list of the best sites in reach from its latest
// pose. A thread keeps the lists up to date, so that a request finds its answer ready.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
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
  // Call it when the flight's pose or wind changed. Never waits.
  void Wake(const std::string& flight_id);
  // The latest answer as JSON text; nothing if there is none yet.
  std::optional<std::string> Find(const std::string& flight_id) const;
  void Forget(const std::string& flight_id);

  // Computes the answer now, keeps it and publishes an event. Empty if there is no such flight.
  std::string Update(const std::string& flight_id);

 private:
  void Run();

  const Storage& storage_;
  MapCache& maps_;
  EventLog& events_;
  // Guards due_, answers_ and is_stopping_.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> due_;
  std::map<std::string, std::string> answers_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace freelsd
