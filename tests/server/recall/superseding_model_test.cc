// Random sequences of flights over the same fields (experiments and loose aircraft too),
// evaluations, deletions and restarts, held against a plain model of what may be served.
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/recall/flown_ground.h"

namespace freelsd {
namespace {

// FREELSD_MODEL_STEPS sets another number.
constexpr int kNumSteps = 2000;
constexpr int kNumPlaces = 2;
constexpr int kNumFlights = 6;
// Beside them, flights whose times are not exact.
constexpr int kNumInexactFlights = 3;
constexpr int kNumGrounds = static_cast<int>(Ground::kDiscUnseenTree) + 1;
constexpr int kStepsBetweenServers = 500;
// Of the flights, the last one is an experiment, and the one before has a loose aircraft.
constexpr int kExperiment = kNumFlights - 1;
constexpr int kLoose = kNumFlights - 2;
constexpr int64_t kBegin = 1600000000000000;
constexpr BoundingBox kEverywhere{-180.0, -90.0, 180.0, 90.0};

enum class Says { kHolds, kFails, kDoubts, kNothing };

// What a map of this ground says of a plan, by the list of grounds alone.
Says OfPlan(Ground ground, bool is_strict_plan) {
  switch (ground) {
    case Ground::kFree:
    case Ground::kTreeAside:
    case Ground::kHazardAside:
      return Says::kHolds;
    case Ground::kSlope:
      return is_strict_plan ? Says::kDoubts : Says::kHolds;
    case Ground::kHazardInDisc:
      return Says::kDoubts;
    case Ground::kDiscUnseen:
      return Says::kNothing;
    default:
      return Says::kFails;
  }
}

// Served, or the reason on record; or the flight that doubts it.
struct Expected {
  std::string superseded_by;
  std::string doubted_by;
  // Of either.
  int64_t at_us = 0;
  int64_t last_seen_us = 0;

  bool operator==(const Expected&) const = default;
  bool IsContested() const { return !superseded_by.empty() && at_us == 0; }
};

// Whether the ground of one flight was photographed after that of another, by plain intervals.
enum class Order { kEarlier, kContested, kLater };
Order OrderOf(const Flown& map, const Flown& site) {
  const auto latest = [](const Flown& flown) {
    return flown.seen_until_us.value_or(flown.seen_at_us == 0 ? INT64_MAX : flown.seen_at_us);
  };
  if (map.seen_at_us > latest(site)) return Order::kLater;
  if (site.seen_at_us > latest(map)) return Order::kEarlier;
  const bool are_exact = map.seen_at_us == latest(map) && site.seen_at_us == latest(site);
  return are_exact ? Order::kEarlier : Order::kContested;
}

// A doubt of a map whose time is not exact is never surely earlier than what confirms.
Order OrderFor(Says says, const Flown& map, const Flown& site) {
  const Order order = OrderOf(map, site);
  const bool is_inexact = says == Says::kDoubts && map.seen_until_us && order == Order::kLater;
  return is_inexact ? Order::kContested : order;
}

using Records = std::map<std::string, Expected>;

class Model {
 public:
  void Put(const Flown& flown) { stored_[IdOf(flown)] = maps_[IdOf(flown)] = flown; }
  // The map stays.
  void Delete(const std::string& id) { stored_.erase(id); }
  // True if a site of the flight was left.
  bool ForgetFlight(const std::string& flight_id) {
    const auto is_of_it = [&](const auto& each) { return each.second.flight_id == flight_id; };
    return std::erase_if(stored_, is_of_it) + std::erase_if(maps_, is_of_it) > 0;
  }
  bool IsEmpty() const { return stored_.empty(); }
  std::string Pick(size_t number) const {
    return std::next(stored_.begin(), static_cast<std::ptrdiff_t>(number % stored_.size()))->first;
  }
  Records Accepted() const {
    Records records;
    for (const auto& [id, site] : stored_) {
      if (site.is_accepted) records[id] = OfSite(site);
    }
    return records;
  }
  // For everyone.
  std::set<std::string> Served() const {
    return Standing([](const Flown& site) { return !site.is_experiment; });
  }
  // In a recall at a place: for everyone, or with ?flight= of the experiment.
  std::set<std::string> ServedAt(int place, bool is_for_experiment) const {
    return Standing([=](const Flown& site) {
      return site.place == place && (is_for_experiment || !site.is_experiment);
    });
  }
  // Rejected ones included, and those that a map rejects which may be later or earlier.
  std::set<std::string> Listed() const {
    std::set<std::string> ids = Standing([](const Flown&) { return true; });
    for (const auto& [id, record] : Accepted()) {
      if (record.IsContested()) ids.insert(id);
    }
    for (const auto& [id, site] : stored_) {
      if (!site.is_accepted) ids.insert(id);
    }
    return ids;
  }

 private:
  template <typename Wanted>
  std::set<std::string> Standing(const Wanted& is_wanted) const {
    std::set<std::string> ids;
    for (const auto& [id, record] : Accepted()) {
      if (record.superseded_by.empty() && is_wanted(stored_.at(id))) ids.insert(id);
    }
    return ids;
  }

  // The flight of the strongest map that says so of the site, and since when: the latest one; of
  // those whose order is contested (0), the one with the greatest id. Empty if there is none. Times
  // of two dated flights differ.
  std::pair<std::string, int64_t> Strongest(const Flown& site, Says wanted, Order order) const {
    std::pair<int64_t, std::string> strongest{0, ""};
    for (const auto& [id, map] : maps_) {
      const bool is_judge = map.place == site.place && map.flight_id != site.flight_id &&
                            !map.is_experiment && !map.is_loose &&
                            OrderFor(wanted, map, site) == order;
      if (!is_judge || OfPlan(map.ground, site.is_strict) != wanted) continue;
      strongest = std::max(strongest, {order == Order::kLater ? map.seen_at_us : 0, map.flight_id});
    }
    return {strongest.second, strongest.first};
  }
  // The flight's site at this place, else the flight.
  std::string NameOf(const std::string& flight_id, const Flown& there) const {
    Flown shown = there;
    shown.flight_id = flight_id;
    return stored_.contains(IdOf(shown)) ? IdOf(shown) : flight_id;
  }

  Expected OfSite(const Flown& site) const {
    const auto confirmed = Strongest(site, Says::kHolds, Order::kLater);
    const int64_t last_seen_us = std::max(site.seen_at_us, confirmed.second);
    for (const Order order : {Order::kLater, Order::kContested}) {
      const auto [flight_id, at_us] = Strongest(site, Says::kFails, order);
      if (!flight_id.empty()) return {NameOf(flight_id, site), "", at_us, last_seen_us};
    }
    for (const Order order : {Order::kContested, Order::kLater}) {
      const auto [flight_id, at_us] = Strongest(site, Says::kDoubts, order);
      const bool is_settled = order == Order::kLater && at_us <= confirmed.second;
      if (!flight_id.empty() && !is_settled) return {"", flight_id, at_us, last_seen_us};
    }
    return {"", "", 0, last_seen_us};
  }

  // By id of the site, which each map has or had.
  std::map<std::string, Flown> stored_, maps_;
};

Records RecordsOf(const Storage& storage) {
  Records records;
  for (const SiteRow& row : storage.sites.List(std::nullopt, std::nullopt)) {
    if (row.approach_json.empty()) continue;
    records[row.id] = {row.superseded_by.value_or(""),
                       row.IsDoubted() ? row.JudgeId() : "",
                       row.superseded_at_us,
                       row.LastSeenUs()};
    const bool is_sure = !row.superseded_by && !row.IsDoubted();
    CHECK(row.superseded_reason.empty() == is_sure);
    CHECK(row.superseded_detail.empty() == is_sure);
  }
  return records;
}

std::set<std::string> RecalledIds(const Storage& storage) {
  std::set<std::string> ids;
  for (const auto& row : storage.sites.ListRecallable(kEverywhere)) ids.insert(row->site_id);
  return ids;
}

std::set<std::string> IdsIn(httplib::Client& client, const std::string& path) {
  std::set<std::string> ids;
  const nlohmann::json collection = GetJson(client, path);
  for (const auto& feature : collection["features"]) ids.insert(feature["properties"]["id"]);
  return ids;
}

// Each flight has one time, also if it is evaluated again; the flights come in any order. The first
// inexact one is in local time, the next undated but uploaded amid the others, the last undated.
Flown FlightNumber(int flight) {
  Flown flown{.flight_id = "f" + std::to_string(flight),
              .seen_at_us = kBegin + 1000000 * ((flight * 5) % kNumFlights),
              .is_loose = flight == kLoose,
              .is_experiment = flight == kExperiment};
  if (flight < kNumFlights) return flown;
  flown.seen_at_us = flight == kNumFlights ? kBegin + 1500000 : 0;
  if (flight < kNumFlights + 2) flown.seen_until_us = kBegin + 3500000;
  return flown;
}

// What a recall or a list of alternates tells of a place.
void CheckTold(const nlohmann::json& answer,
               const std::set<std::string>& served,
               const Records& records) {
  CAPTURE(answer.dump());
  // All sites of a place are one landing, of which the best is told.
  CHECK(answer["sites"].empty() == served.empty());
  for (const nlohmann::json& site : answer["sites"]) {
    CHECK(served.contains(site["site_id"]));
    const bool is_doubted = !records.at(site["site_id"]).doubted_by.empty();
    const bool are_all = std::none_of(served.begin(), served.end(), [&](const std::string& id) {
      return records.at(id).doubted_by.empty();
    });
    CHECK(is_doubted == are_all);
    CHECK(site.contains("doubted_at") == is_doubted);
    if (is_doubted) CHECK(site["verdict"] == "unverified");
    const bool is_of_experiment = site["flight_id"] == FlightNumber(kExperiment).flight_id;
    CHECK(site.contains("memory") == is_of_experiment);
  }
}

class Walk {
 public:
  explicit Walk(unsigned seed) : random_(seed) { Open(); }

  void Step(int number) {
    const int choice = Draw(100);
    if (choice < 70 || model_.IsEmpty()) {
      PutSome(number);
    } else if (choice < 90) {
      const std::string id = model_.Pick(random_());
      CHECK(ForgetSite(*storage_, *maps_, id));
      model_.Delete(id);
    } else if (choice < 97) {
      const std::string id = FlightNumber(Draw(kNumFlights + kNumInexactFlights)).flight_id;
      const bool was_stored = storage_->flights.Find(id).has_value();
      const bool was_there = model_.ForgetFlight(id) || was_stored;
      CHECK(ForgetFlight(*storage_, *maps_, id) == was_there);
    } else {
      storage_.reset();
      Open();
    }
    CHECK((RecordsOf(*storage_) == model_.Accepted()));
    CHECK((RecalledIds(*storage_) == model_.Served()));
  }

  // Lists, exports, recall and alternates over HTTP, and then a flight is deleted.
  void Serve() {
    storage_.reset();
    {
      TestServer server(TestConfig(folder_.path()));
      httplib::Client client = server.Client();
      CheckLists(client);
      CheckRecall(client);
      DeleteFlight(client);
      CheckLists(client);
    }
    Open();
  }

 private:
  int Draw(int end) { return static_cast<int>(random_() % static_cast<unsigned>(end)); }

  void CheckLists(httplib::Client& client) const {
    CHECK((IdsIn(client, "/v1/sites") == model_.Listed()));
    CHECK((IdsIn(client, "/v1/emergency/export") == model_.Served()));
    const nlohmann::json all = GetJson(client, "/v1/sites?include=superseded");
    const Records records = model_.Accepted();
    size_t num_accepted = 0;
    for (const nlohmann::json& feature : all["features"]) {
      const nlohmann::json& site = feature["properties"];
      const auto record = records.find(site["id"]);
      if (record == records.end()) continue;
      ++num_accepted;
      const bool is_contested = record->second.IsContested();
      CHECK(site.value("superseded_by", "") == (is_contested ? "" : record->second.superseded_by));
      const std::string& doubting = record->second.doubted_by;
      CHECK(site.value("doubted_by", "") == doubting);
      if (is_contested) CHECK(site["verdict"] == "rejected");
      const std::string verdict = doubting.empty() ? "landable" : "unverified";
      if (record->second.superseded_by.empty()) CHECK(site["verdict"] == verdict);
      const auto file = client.Get("/v1/sites/" + record->first + "?f=csv");
      const bool is_superseded = !record->second.superseded_by.empty() && !is_contested;
      CHECK(file->status == (is_superseded ? 409 : 200));
    }
    CHECK(num_accepted == records.size());
  }

  void CheckRecall(httplib::Client& client) const {
    const Records records = model_.Accepted();
    for (int place = 0; place < kNumPlaces; ++place) {
      const GeoPoint touchdown = TouchdownOf(place);
      const std::string pose = "latitude_deg=" + std::to_string(touchdown.latitude_deg) +
                               "&longitude_deg=8&altitude_m=600&heading_deg=0"
                               "&wind_east_mps=0&wind_north_mps=-4&limit=50&glide_ratio=7";
      const nlohmann::json answer = GetJson(client, "/v1/emergency?" + pose);
      CheckTold(answer, model_.ServedAt(place, false), records);
      for (const bool is_experiment : {false, true}) {
        const std::string flight = PostLive(client, touchdown, is_experiment);
        CheckTold(GetJson(client, "/v1/flights/" + flight + "/alternates"),
                  model_.ServedAt(place, false),
                  records);
        CHECK(client.Delete("/v1/flights/" + flight)->status == 204);
      }
      const std::string experiment = FlightNumber(kExperiment).flight_id;
      if (client.Get("/v1/flights/" + experiment)->status != 200) continue;
      CheckTold(GetJson(client, "/v1/emergency?flight=" + experiment + "&" + pose),
                model_.ServedAt(place, true),
                records);
    }
  }

  static std::string PostLive(httplib::Client& client, const GeoPoint& above, bool is_experiment) {
    const std::string memory = is_experiment ? "none" : "keep";
    const auto posted =
        client.Post("/v1/flights",
                    R"({"name":"live","aircraft":{"profile":"small"},"memory":")" + memory + "\"}",
                    "application/json");
    std::string flight = nlohmann::json::parse(posted->body)["id"];
    const nlohmann::json sample{{"timestamp_us", NowUs()},
                                {"position",
                                 {{"latitude_deg", above.latitude_deg},
                                  {"longitude_deg", above.longitude_deg},
                                  {"altitude_m", 600.0}}},
                                {"wind", {{"east_mps", 0.0}, {"north_mps", -4.0}}}};
    const auto told = client.Post(
        "/v1/flights/" + flight + "/telemetry", sample.dump() + "\n", "application/x-ndjson");
    CHECK(told->status == 200);
    return flight;
  }

  // With its sites, or without: then they stay, and can be forgotten when the flight is gone.
  void DeleteFlight(httplib::Client& client) {
    const std::string id = FlightNumber(Draw(kNumFlights + kNumInexactFlights)).flight_id;
    const std::string path = "/v1/flights/" + id;
    const bool is_stored = client.Get(path)->status == 200;
    if (Draw(2) == 0) CHECK(client.Delete(path)->status == (is_stored ? 204 : 404));
    CheckLists(client);
    if (Draw(2) == 0) return;
    const bool is_there = client.Get(path)->status == 200;
    const bool was_left = model_.ForgetFlight(id);
    CHECK(client.Delete(path + "?forget_sites=true")->status == (is_there || was_left ? 204 : 404));
  }

  void PutSome(int number) {
    Flown flown = FlightNumber(Draw(kNumFlights + kNumInexactFlights));
    flown.place = flown.region_id = Draw(kNumPlaces);
    flown.ground = Draw(2) == 0 ? Ground::kFree : static_cast<Ground>(Draw(kNumGrounds));
    flown.is_strict = Draw(2) == 0;
    // A site is accepted only where its plan holds.
    flown.is_accepted = OfPlan(flown.ground, flown.is_strict) == Says::kHolds && Draw(3) > 0;
    flown.updated_at_us = number + 1;
    if (!storage_->flights.Find(flown.flight_id)) storage_->flights.Insert(FlightOf(flown));
    Store(*storage_, *maps_, flown);
    model_.Put(flown);
  }

  void Open() {
    storage_ = std::make_unique<Storage>(StorageAt(folder_.path()));
    maps_ = std::make_unique<MapCache>(CacheSizes{size_t{1} << 24, size_t{1} << 22});
  }

  std::mt19937 random_;
  TemporaryFolder folder_;
  std::unique_ptr<Storage> storage_;
  std::unique_ptr<MapCache> maps_;
  Model model_;
};

TEST_CASE("memory: random steps, and what is served is what a plain model serves") {
  Walk walk(20240611);
  const char* const given = std::getenv("FREELSD_MODEL_STEPS");
  const int num_steps = given == nullptr ? kNumSteps : std::atoi(given);
  for (int step = 0; step < num_steps; ++step) {
    INFO(step);
    walk.Step(step);
    if (step % kStepsBetweenServers == kStepsBetweenServers - 1) walk.Serve();
  }
}

}  // namespace
}  // namespace freelsd
