// Alternates: for each flight that sends data, a list of the best sites in reach from its latest
// pose. Two threads keep the lists up to date, so that a request finds its answer ready.
//
// Plans depend on the wind, not on the pose, and take most of the time. So one thread updates all
// lists for the latest poses with the plans that exist. The other plans for the latest wind of one
// flight at a time. A list tells the wind that it is planned for, and the age of this wind.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "server/recall/live_pose/live_pose.h"

namespace freelsd {

class EventLog;
class MapCache;
class Storage;

// Thread-safe.
class Alternates {
 public:
  // `num_sites`: length of the lists. Storage, maps and events must live until Stop returns.
  Alternates(const Storage& storage, MapCache& maps, EventLog& events, size_t num_sites)
      : storage_(storage), maps_(maps), events_(events), num_sites_(num_sites) {}
  ~Alternates();
  Alternates(const Alternates&) = delete;
  Alternates& operator=(const Alternates&) = delete;

  // Does nothing if it was called before.
  void Start();
  void Stop();
  // Call it when the flight's pose or wind changed. Returns at once; the threads update the flights
  // in turn.
  void Wake(const std::string& flight_id);
  // Call it when stored sites changed. The lists of recently woken flights are computed again. All
  // other lists are dropped and computed on request.
  void WakeAll();
  void Forget(const std::string& flight_id);

  // The best `limit` sites (default: the length of the lists) as JSON text, with ages as of now.
  // Uses the kept list if it is long enough and still valid. Otherwise computes a new list. Empty
  // if there is no such flight.
  std::string Answer(const std::string& flight_id, std::optional<size_t> limit = std::nullopt);
  // The kept list, of any age; nothing if there is none.
  std::optional<nlohmann::json> Kept(const std::string& flight_id) const;

 private:
  using Clock = std::chrono::steady_clock;
  // The wind that a flight's list is planned for.
  struct PlannedWind {
    std::optional<LiveWind> wind;
    // When it was the latest, on the clock of ArrivalNowUs.
    int64_t taken_at_us = 0;
    // How much the latest wind differs from it, m/s.
    double change_mps = 0.0;
  };
  // NOLINTNEXTLINE(bugprone-exception-escape): an empty json throws nothing.
  struct List {
    nlohmann::json answer;
    PlannedWind planned_wind;
    // Greater for a list whose computation began later.
    uint64_t number = 0;
    // Version of the stored sites when the computation began.
    uint64_t sites_version = 0;
    // On the clock of ArrivalNowUs.
    int64_t computed_at_us = 0;
    // Time at which the course that the list was computed for becomes too old, or its wind is worth
    // less. Nothing if the list uses neither.
    std::optional<int64_t> holds_until_us;
    // When the next obstacle expires, on the clock of NowUs: sites may be free from then on.
    std::optional<int64_t> obstacles_hold_until_us;

    bool IsOutdated(uint64_t version) const;
    bool HasObstacleExpired() const;
  };
  enum class WindToPlanFor { kPlanned, kLatest };

  void Enqueue(const std::string& flight_id);
  // The flights whose list was computed with an obstacle that has expired. The caller holds mutex_.
  void EnqueueExpired();
  void RunUpdates();
  void RunPlans();
  // The caller holds mutex_, also for the next three. The flight that waits longest, of those that
  // have a list; empty if there is none.
  std::string NextToUpdate() const;
  // A flight without a list, or the one whose wind has changed most. Empty if no flight needs a
  // plan.
  std::string NextToPlan() const;
  // True if the period since the flight's last update, or since its last plan, is over.
  bool IsTimeToUpdate(const std::string& flight_id) const;
  bool IsTimeToPlan(const std::string& flight_id) const;
  // Computes and keeps the list, and logs errors. The caller does not hold mutex_.
  void Update(const std::string& flight_id, WindToPlanFor wind);
  // Nothing if there is no such flight. A wind that has changed much is always the latest.
  std::optional<List> Compute(const std::string& flight_id, size_t limit, WindToPlanFor wind);
  // Replaces the wind of the pose by the planned one, if that is to be taken and similar.
  PlannedWind ChooseWind(const std::string& flight_id,
                         WindToPlanFor choice,
                         int64_t now_us,
                         LivePose& pose);
  // Keeps the list and publishes an event. If a later list is kept already, only the wind is kept:
  // it has plans now.
  void Keep(const std::string& flight_id, List list);

  const Storage& storage_;
  MapCache& maps_;
  EventLog& events_;
  const size_t num_sites_;
  // Guards all members below except the threads.
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Flights to update, in the order of their Wake calls, each at most once.
  std::deque<std::string> due_;
  std::map<std::string, Clock::time_point> woken_at_;
  std::map<std::string, Clock::time_point> updated_at_;
  std::map<std::string, List> lists_;
  std::map<std::string, PlannedWind> planned_winds_;
  uint64_t num_lists_ = 0;
  bool is_stopping_ = false;
  std::thread update_thread_;
  std::thread plan_thread_;
};

}  // namespace freelsd
