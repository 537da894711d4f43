// Random sequences of flights over the same fields, re-evaluations, deletions and restarts, held
// against a plain model of what may be served.
#include <map>
#include <memory>
#include <random>
#include <set>
#include <thread>
#include <tuple>

#include <doctest/doctest.h>

#include "tests/server/meadow.h"
#include "tests/server/recall/flown_ground.h"

namespace freelsd {
namespace {

constexpr int kNumSteps = 10000;
constexpr int kNumPlaces = 2;
constexpr int kNumFlights = 6;
// Beside them, flights whose times are not exact.
constexpr int kNumInexactFlights = 3;
constexpr int kNumGrounds = static_cast<int>(Ground::kDiscUnseenTree) + 1;
constexpr int kStepsBetweenServers = 1000;
constexpr int64_t kBegin = 1600000000000000;
constexpr BoundingBox kEverywhere{-180.0, -90.0, 180.0, 90.0};

enum class Says { kHolds, kFails, kNothing };

// What a map of this ground says of a plan, by the list of grounds alone.
Says OfPlan(Ground ground, bool is_strict_plan) {
  switch (ground) {
    case Ground::kFree:
    case Ground::kTreeAside:
      return Says::kHolds;
    case Ground::kSlope:
      return is_strict_plan ? Says::kFails : Says::kHolds;
    case Ground::kDiscUnseen:
      return Says::kNothing;
    default:
      return Says::kFails;
  }
}

// Served, or the reason on record.
struct Expected {
  std::string superseded_by;
  int64_t superseded_at_us = 0;
  int64_t last_seen_us = 0;

  bool operator==(const Expected&) const = default;
  bool IsContested() const { return !superseded_by.empty() && superseded_at_us == 0; }
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

using Records = std::map<std::string, Expected>;

class Model {
 public:
  void Put(const Flown& flown) { stored_[IdOf(flown)] = flown; }
  void Delete(const std::string& id) { stored_.erase(id); }
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
  std::set<std::string> Served() const {
    std::set<std::string> ids;
    for (const auto& [id, record] : Accepted()) {
      if (record.superseded_by.empty()) ids.insert(id);
    }
    return ids;
  }
  // Rejected ones included, and those that a map rejects which may be later or earlier.
  std::set<std::string> Listed() const {
    std::set<std::string> ids = Served();
    for (const auto& [id, record] : Accepted()) {
      if (record.IsContested()) ids.insert(id);
    }
    for (const auto& [id, site] : stored_) {
      if (!site.is_accepted) ids.insert(id);
    }
    return ids;
  }

 private:
  Expected OfSite(const Flown& site) const {
    Expected expected;
    expected.last_seen_us = site.seen_at_us;
    for (const auto& [id, map] : stored_) {
      if (map.place != site.place || map.flight_id == site.flight_id) continue;
      const Order order = OrderOf(map, site);
      if (order == Order::kEarlier) continue;
      const Says says = OfPlan(map.ground, site.is_strict);
      if (says == Says::kHolds && order == Order::kLater)
        expected.last_seen_us = std::max(expected.last_seen_us, map.seen_at_us);
      const std::pair since(order == Order::kLater ? map.seen_at_us : 0, id);
      if (says == Says::kFails &&
          since > std::pair(expected.superseded_at_us, expected.superseded_by)) {
        std::tie(expected.superseded_at_us, expected.superseded_by) = since;
      }
    }
    return expected;
  }

  std::map<std::string, Flown> stored_;
};

Records RecordsOf(const Storage& storage) {
  Records records;
  for (const SiteRow& row : storage.sites.List(std::nullopt, std::nullopt)) {
    if (row.approach_json.empty()) continue;
    records[row.id] = {row.superseded_by.value_or(""), row.superseded_at_us, row.LastSeenUs()};
    CHECK(row.superseded_reason.empty() == !row.superseded_by);
    CHECK(row.superseded_detail.empty() == !row.superseded_by);
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
  for (const nlohmann::json& feature : collection["features"]) {
    ids.insert(feature["properties"]["id"]);
  }
  return ids;
}

class Walk {
 public:
  explicit Walk(unsigned seed) : random_(seed) { Open(); }

  void Step(int number) {
    const int choice = Draw(100);
    if (choice < 70 || model_.IsEmpty()) {
      PutSome(number);
    } else if (choice < 97) {
      const std::string id = model_.Pick(random_());
      CHECK(ForgetSite(*storage_, *maps_, id));
      model_.Delete(id);
    } else {
      storage_.reset();
      Open();
    }
    CHECK((RecordsOf(*storage_) == model_.Accepted()));
    CHECK((RecalledIds(*storage_) == model_.Served()));
  }

  // Lists and exports over HTTP.
  void Serve() {
    storage_.reset();
    {
      TestServer server(TestConfig(folder_.path()));
      httplib::Client client = server.Client();
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
        CHECK((site["verdict"] == "rejected") == is_contested);
        CHECK(site.value("superseded_by", "") ==
              (is_contested ? "" : record->second.superseded_by));
        const auto file = client.Get("/v1/sites/" + record->first + "?f=cup");
        CHECK(file->status == (record->second.superseded_by.empty() ? 200 : 409));
      }
      CHECK(num_accepted == records.size());
    }
    Open();
  }

 private:
  int Draw(int end) { return static_cast<int>(random_() % static_cast<unsigned>(end)); }

  void PutSome(int number) {
    const int flight = Draw(kNumFlights + kNumInexactFlights);
    const int place = Draw(kNumPlaces);
    // Each flight has one time, also if it is evaluated again; the flights come in any order.
    Flown flown{.flight_id = "f" + std::to_string(flight),
                .seen_at_us = kBegin + 1000000 * ((flight * 5) % kNumFlights),
                .ground = Draw(2) == 0 ? Ground::kFree : static_cast<Ground>(Draw(kNumGrounds)),
                .is_strict = Draw(2) == 0,
                .is_accepted = Draw(3) > 0,
                .place = place,
                .updated_at_us = number + 1,
                .region_id = place};
    if (flight >= kNumFlights) flown = Inexact(std::move(flown), flight - kNumFlights);
    Store(*storage_, *maps_, flown);
    model_.Put(flown);
  }

  // In local time, undated but uploaded amid the other flights, undated.
  static Flown Inexact(Flown flown, int number) {
    flown.seen_at_us = number == 0 ? kBegin + 1500000 : 0;
    if (number < 2) flown.seen_until_us = kBegin + 3500000;
    return flown;
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

TEST_CASE("memory: 10 000 random steps, and what is served is what a plain model serves") {
  Walk walk(20240611);
  for (int step = 0; step < kNumSteps; ++step) {
    INFO(step);
    walk.Step(step);
    if (step % kStepsBetweenServers == kStepsBetweenServers - 1) walk.Serve();
  }
}

}  // namespace
}  // namespace freelsd
