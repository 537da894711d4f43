#include "server/recall/alternates.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include <spdlog/spdlog.h>

#include "api/stored/stored.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/recall/live_pose/live_pose.h"
#include "server/recall/recall_sites.h"

namespace freelsd {
namespace {

// Least time between two updates or two plans of one flight, because its poses may arrive 50 times
// a second.
constexpr std::chrono::milliseconds kMinPeriod{100};
constexpr std::chrono::milliseconds kPollPeriod{10};
// How long a list may show an obstacle that has expired.
constexpr std::chrono::milliseconds kExpiryPeriod{500};
// A wind that has changed by no more is the same as far as anyone can measure it: its plans hold.
constexpr double kSameWindMps = 0.25;
// Plans hold for a wind that has changed by no more, until there is time for new ones.
constexpr double kMaxPlannedChangeMps = 1.0;
// A flight that was not woken for this time has landed, or a client only requested its list.
constexpr std::chrono::seconds kLiveFor{60};

std::chrono::nanoseconds ProcessorTimeOfThread() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

nlohmann::json PoseJson(const LivePose& pose, const std::string& altitude_datum) {
  nlohmann::json object{{"latitude_deg", pose.place.latitude_deg},
                        {"longitude_deg", pose.place.longitude_deg},
                        {"altitude_m", pose.place.altitude_m},
                        {"altitude_datum", altitude_datum},
                        {"age_s", nullptr}};
  if (pose.heading_deg) object["heading_deg"] = *pose.heading_deg;
  if (pose.timestamp_us) object["timestamp_us"] = *pose.timestamp_us;
  if (pose.age_s) object["age_s"] = *pose.age_s;
  return object;
}

nlohmann::json AnswerOf(const StoredSites& stored,
                        const FlightRow& flight,
                        const std::optional<LivePose>& pose,
                        size_t limit) {
  nlohmann::json answer{{"flight_id", flight.id}, {"sites", nlohmann::json::array()}};
  answer["updated_at"] = Rfc3339(NowUs());
  if (!pose) {
    answer["warnings"] = {"no pose of the flight is known yet"};
    return answer;
  }
  const StoredFlight flight_request = ParseStoredFlight(flight.request_json);
  EmergencyRequest request;
  request.place = pose->place;
  request.altitude_datum = AltitudeDatumOf(flight);
  request.flight_id = flight.id;
  request.is_of_experiment = !flight_request.memory.is_kept;
  if (pose->wind) request = InWind(request, WindOfNowOf(*pose->wind));
  // If the heading is unknown, recall assumes the worst heading, and adds a warning.
  request.heading_deg = pose->heading_deg;
  request.aircraft = flight_request.aircraft;
  request.limit = limit;
  answer.update(RecallSites(stored, request));
  answer["pose"] = PoseJson(*pose, *request.altitude_datum);
  if (pose->wind) answer["wind"] = WindJson(*pose->wind);
  return answer;
}

// Until the course is too old, or the wind is worth less. Nothing: for ever.
std::optional<double> HoldsForS(const LivePose& pose) {
  std::optional<double> seconds;
  if (pose.wind) seconds = WindOfNowOf(*pose.wind).holds_for_s;
  if (!pose.heading_deg) return seconds;
  const double of_course_s = kMaxCourseAgeS - pose.age_s.value_or(0.0);
  return std::min(of_course_s, seconds.value_or(of_course_s));
}

void AddAge(double seconds, nlohmann::json& object) {
  const auto age = object.find("age_s");
  if (age != object.end() && age->is_number()) *age = age->get<double>() + seconds;
}

// The answer `seconds` after it was computed, with the first `limit` of its sites.
nlohmann::json AfterSeconds(nlohmann::json answer, double seconds, size_t limit) {
  nlohmann::json& sites = answer["sites"];
  while (sites.size() > limit) sites.erase(sites.size() - 1);
  for (nlohmann::json& site : sites) AddAge(seconds, site);
  for (const char* const name : {"pose", "wind", "nearest_miss"}) {
    if (const auto part = answer.find(name); part != answer.end()) AddAge(seconds, *part);
  }
  return answer;
}

}  // namespace

Alternates::~Alternates() { Stop(); }

void Alternates::Start() {
  const std::lock_guard lock(mutex_);
  if (update_thread_.joinable()) return;
  update_thread_ = std::thread([this] { RunUpdates(); });
  plan_thread_ = std::thread([this] { RunPlans(); });
}

void Alternates::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  if (update_thread_.joinable()) update_thread_.join();
  if (plan_thread_.joinable()) plan_thread_.join();
}

void Alternates::Enqueue(const std::string& flight_id) {
  if (std::find(due_.begin(), due_.end(), flight_id) == due_.end()) due_.push_back(flight_id);
}

void Alternates::EnqueueExpired() {
  for (const auto& [flight_id, list] : lists_) {
    const bool is_over = list.holds_until_us && ArrivalNowUs() > *list.holds_until_us;
    if (is_over || list.HasObstacleExpired()) Enqueue(flight_id);
  }
}

// The list is invalid if a site was deleted or superseded, if the aircraft may have left the course
// for which the list was computed, or if an obstacle has expired.
bool Alternates::List::IsOutdated(uint64_t version) const {
  return sites_version != version || (holds_until_us && ArrivalNowUs() > *holds_until_us) ||
         HasObstacleExpired();
}

bool Alternates::List::HasObstacleExpired() const {
  return obstacles_hold_until_us && NowUs() >= *obstacles_hold_until_us;
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
    std::erase_if(lists_, [&](const auto& kept) { return !woken_at_.contains(kept.first); });
    std::erase_if(updated_at_, [&](const auto& kept) { return !woken_at_.contains(kept.first); });
    std::erase_if(planned_winds_,
                  [&](const auto& kept) { return !woken_at_.contains(kept.first); });
    for (const auto& [flight_id, woken_at] : woken_at_) Enqueue(flight_id);
  }
  changed_.notify_all();
}

std::optional<nlohmann::json> Alternates::Kept(const std::string& flight_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = lists_.find(flight_id);
  if (found == lists_.end()) return std::nullopt;
  return found->second.answer;
}

void Alternates::Forget(const std::string& flight_id) {
  const std::lock_guard lock(mutex_);
  lists_.erase(flight_id);
  woken_at_.erase(flight_id);
  updated_at_.erase(flight_id);
  planned_winds_.erase(flight_id);
  std::erase(due_, flight_id);
}

std::string Alternates::Answer(const std::string& flight_id, std::optional<size_t> limit) {
  const size_t num_sites = limit.value_or(num_sites_);
  std::optional<List> list;
  if (num_sites <= num_sites_) {
    const std::lock_guard lock(mutex_);
    if (const auto found = lists_.find(flight_id); found != lists_.end()) list = found->second;
  }
  if (list && list->IsOutdated(storage_.sites.Version())) list.reset();
  if (!list) {
    list = Compute(flight_id, std::max(num_sites, num_sites_), WindToPlanFor::kPlanned);
    if (!list) return {};
    if (num_sites <= num_sites_) Keep(flight_id, *list);
  }
  const double seconds = static_cast<double>(ArrivalNowUs() - list->computed_at_us) * 1e-6;
  return AfterSeconds(std::move(list->answer), seconds, num_sites).dump();
}

Alternates::PlannedWind Alternates::ChooseWind(const std::string& flight_id,
                                               WindToPlanFor choice,
                                               int64_t now_us,
                                               LivePose& pose) {
  PlannedWind latest{pose.wind, now_us, 0.0};
  const std::lock_guard lock(mutex_);
  const auto found = planned_winds_.find(flight_id);
  if (choice == WindToPlanFor::kLatest || found == planned_winds_.end()) return latest;
  PlannedWind planned = found->second;
  if (!planned.wind || !pose.wind) return latest;
  planned.change_mps = (pose.wind->wind_in_world - planned.wind->wind_in_world).norm();
  if (planned.change_mps > kMaxPlannedChangeMps) return latest;
  if (planned.change_mps <= kSameWindMps) {
    // Measured again, it is as young as the latest.
    pose.wind->wind_in_world = planned.wind->wind_in_world;
    return {pose.wind, now_us, 0.0};
  }
  pose.wind = planned.wind;
  const double seconds = static_cast<double>(now_us - planned.taken_at_us) * 1e-6;
  if (pose.wind->age_s) *pose.wind->age_s += seconds;
  return planned;
}

std::optional<Alternates::List> Alternates::Compute(const std::string& flight_id,
                                                    size_t num_sites,
                                                    WindToPlanFor wind) {
  List list;
  {
    const std::lock_guard lock(mutex_);
    list.number = ++num_lists_;
  }
  const auto hold = storage_.HoldVersions();
  list.sites_version = storage_.sites.Version();
  list.computed_at_us = ArrivalNowUs();
  list.obstacles_hold_until_us = maps_.NextObstacleExpiryUs(storage_);
  const std::optional<FlightRow> flight = storage_.flights.Find(flight_id);
  if (!flight) return std::nullopt;
  std::optional<LivePose> pose = LivePoseOf(storage_, flight_id, list.computed_at_us);
  if (pose) list.planned_wind = ChooseWind(flight_id, wind, list.computed_at_us, *pose);
  if (const auto seconds = pose ? HoldsForS(*pose) : std::nullopt) {
    list.holds_until_us = list.computed_at_us + static_cast<int64_t>(*seconds * 1e6);
  }
  // With plans also for the sites that a recall tells if nobody gives a limit.
  const size_t num_planned = std::max(num_sites, EmergencyRequest{}.limit);
  list.answer = AnswerOf({storage_, maps_}, *flight, pose, num_planned);
  nlohmann::json& sites = list.answer["sites"];
  while (sites.size() > num_sites) sites.erase(sites.size() - 1);
  return list;
}

void Alternates::Keep(const std::string& flight_id, List list) {
  const std::string text = list.answer.dump();
  {
    const std::lock_guard lock(mutex_);
    PlannedWind& planned = planned_winds_[flight_id];
    if (list.planned_wind.taken_at_us >= planned.taken_at_us) planned = list.planned_wind;
    List& kept = lists_[flight_id];
    if (kept.number > list.number) return;
    std::swap(kept, list);
  }
  events_.Publish("alternates", flight_id, text);
}

std::string Alternates::NextToUpdate() const {
  const auto next = std::find_if(due_.begin(), due_.end(), [this](const std::string& flight_id) {
    return lists_.contains(flight_id);
  });
  return next == due_.end() ? std::string() : *next;
}

std::string Alternates::NextToPlan() const {
  std::string next;
  double most_mps = 0.0;
  for (const std::string& flight_id : due_) {
    if (!lists_.contains(flight_id)) return flight_id;
  }
  for (const auto& [flight_id, planned] : planned_winds_) {
    if (planned.change_mps <= most_mps || !woken_at_.contains(flight_id)) continue;
    most_mps = planned.change_mps;
    next = flight_id;
  }
  return next;
}

bool Alternates::IsTimeToUpdate(const std::string& flight_id) const {
  const auto updated = updated_at_.find(flight_id);
  return updated == updated_at_.end() || Clock::now() >= updated->second + kMinPeriod;
}

bool Alternates::IsTimeToPlan(const std::string& flight_id) const {
  const auto planned = planned_winds_.find(flight_id);
  return planned == planned_winds_.end() ||
         std::chrono::microseconds(ArrivalNowUs() - planned->second.taken_at_us) >= kMinPeriod;
}

void Alternates::Update(const std::string& flight_id, WindToPlanFor wind) {
  try {
    if (auto list = Compute(flight_id, num_sites_, wind)) {
      Keep(flight_id, *std::move(list));
      return;
    }
    const std::lock_guard lock(mutex_);
    planned_winds_.erase(flight_id);
  } catch (const std::exception& error) {
    spdlog::error("alternates of flight {}: {}", flight_id, error.what());
    const std::lock_guard lock(mutex_);
    // An outdated list must not stay: the next pose or the next request computes it.
    lists_.erase(flight_id);
    planned_winds_.erase(flight_id);
  }
}

void Alternates::RunUpdates() {
  std::unique_lock lock(mutex_);
  while (true) {
    EnqueueExpired();
    changed_.wait_for(
        lock, kExpiryPeriod, [this] { return is_stopping_ || !NextToUpdate().empty(); });
    if (is_stopping_) return;
    // All flights have the same period, so none behind the first is due earlier.
    const std::string flight_id = NextToUpdate();
    if (flight_id.empty()) continue;
    if (!IsTimeToUpdate(flight_id)) {
      changed_.wait_for(lock, kPollPeriod, [this] { return is_stopping_; });
      continue;
    }
    std::erase(due_, flight_id);
    updated_at_[flight_id] = Clock::now();
    lock.unlock();
    const std::chrono::nanoseconds before = ProcessorTimeOfThread();
    Update(flight_id, WindToPlanFor::kPlanned);
    const std::chrono::nanoseconds spent = ProcessorTimeOfThread() - before;
    lock.lock();
    // With many live flights, updates never end: half of a processor is left for what they need.
    changed_.wait_for(lock, spent, [this] { return is_stopping_; });
  }
}

void Alternates::RunPlans() {
  // Updates must not wait for plans.
  GiveWay();
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_stopping_ || !NextToPlan().empty(); });
    if (is_stopping_) return;
    const std::string flight_id = NextToPlan();
    if (!IsTimeToPlan(flight_id)) {
      changed_.wait_for(lock, kPollPeriod, [this] { return is_stopping_; });
      continue;
    }
    if (!lists_.contains(flight_id)) std::erase(due_, flight_id);
    lock.unlock();
    Update(flight_id, WindToPlanFor::kLatest);
    lock.lock();
    // A list that has come can be updated; a wind that has changed meanwhile is planned next.
    changed_.notify_all();
  }
}

}  // namespace freelsd
