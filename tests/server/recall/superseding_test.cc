// Memory that neither forgets nor haunts: what a later flight changes of stored sites.
#include "server/recall/superseding.h"

#include <algorithm>

#include <doctest/doctest.h>

#include "tests/server/recall/flown_ground.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr int64_t kFirst = 1600000000000000;  // 2020-09-13T12:26:40Z
constexpr int64_t kLater = kFirst + 86400000000;
constexpr int64_t kLatest = kLater + 86400000000;
constexpr char kLaterText[] = "2020-09-14T12:26:40Z";
// Away from the meadow that the server holds anyway.
constexpr int kPlace = 1;

Flown First(Ground ground = Ground::kFree) {
  return {.flight_id = "first", .seen_at_us = kFirst, .ground = ground, .place = kPlace};
}

// A later flight that accepts nothing.
Flown Later(Ground ground, const std::string& flight_id = "later", int64_t seen_at_us = kLater) {
  return {.flight_id = flight_id,
          .seen_at_us = seen_at_us,
          .ground = ground,
          .is_accepted = false,
          .place = kPlace};
}

struct FieldServer : FlownServer {
  using FlownServer::FlownServer;

  bool IsListed(const std::string& path) const {
    const auto answer = client->Get(path);
    // 409: no site remains for the file.
    REQUIRE((answer->status == 200 || answer->status == 409));
    // Files for autopilots name sites by flight and rank.
    const bool is_file =
        path.find("f=rally") != std::string::npos || path.find("f=plan") != std::string::npos;
    return answer->body.find(is_file ? "field of first" : "first-r1") != std::string::npos;
  }
  // With its map.
  int Forget(const std::string& flight_id) const {
    return client->Delete("/v1/flights/" + flight_id + "?forget_sites=true")->status;
  }
  // In lists, exports and recall alike.
  bool IsServed() const {
    const std::string near = "latitude_deg=47.04&longitude_deg=8&altitude_m=1500";
    const bool is_served = IsListed("/v1/sites");
    for (const std::string& path :
         {std::string("/v1/emergency/export"),
          std::string("/v1/emergency/export?f=rally&home_altitude_m=300"),
          std::string("/v1/emergency/export?f=plan&home_altitude_m=300&bbox=7.9,47.02,8.1,47.1"),
          "/v1/emergency?limit=50&heading_deg=0&wind_east_mps=0&wind_north_mps=-4&" + near}) {
      INFO(path << ": " << client->Get(path)->body);
      CHECK(IsListed(path) == is_served);
    }
    for (const char* const format : {"plan", "waypoints", "cup", "kml", "csv"}) {
      const auto file =
          client->Get(std::string("/v1/sites/first-r1?home_altitude_m=300&f=") + format);
      CHECK(file->status == (is_served ? 200 : 409));
    }
    return is_served;
  }
};

TEST_CASE("memory: a repeat flight's region over the whole survey supersedes no free ground") {
  Flown wide = Later(Ground::kFree);
  wide.half_region_m = 5000.0;
  Flown neighbour = First();
  neighbour.region_id = 2;
  neighbour.place = kPlace + 1;
  const FieldServer field({First(), neighbour, wide});
  CHECK(field.IsServed());
  CHECK_FALSE(field.Site("first-r1").contains("superseded_by"));
  CHECK(field.Site("first-r1")["last_seen_at"] == kLaterText);
  // Not photographed again.
  CHECK(field.Site("first-r2")["last_seen_at"] == "2020-09-13T12:26:40Z");
  const nlohmann::json answer =
      GetJson(*field.client,
              "/v1/emergency?latitude_deg=47.045&longitude_deg=8&altitude_m=900&heading_deg=0"
              "&wind_east_mps=0&wind_north_mps=-4&limit=1");
  CHECK(answer["sites"][0]["site_id"] == "first-r1");
  CHECK(answer["sites"][0]["last_seen_at"] == kLaterText);
}

TEST_CASE("memory: a flight with a stricter aircraft erases nothing whose ground has not changed") {
  Flown strict = Later(Ground::kSlope);
  strict.is_strict = true;
  CHECK(FieldServer({First(Ground::kSlope), strict}).IsServed());
  // For the site of a strict aircraft, the same ground is too steep now. Its heights are the same.
  Flown first = First();
  first.is_strict = true;
  const FieldServer field({first, Later(Ground::kSlope)});
  CHECK(field.IsServed());
  CHECK(field.Site("first-r1")["doubted_by"] == "later");
}

TEST_CASE(
    "memory: a new obstacle supersedes the site whose way down it blocks, with reason and time") {
  const std::vector<std::pair<Ground, const char*>> cases{
      {Ground::kTreeOnFinal, "approach_blocked"}, {Ground::kTreeOnCircle, "loiter_blocked"}};
  for (const auto& [ground, expected_reason] : cases) {
    // A structured binding cannot be captured by doctest's INFO.
    const std::string reason = expected_reason;
    INFO(reason);
    const FieldServer field({First(), Later(ground)});
    CHECK_FALSE(field.IsServed());
    CHECK(field.IsListed("/v1/sites?include=superseded"));
    const nlohmann::json site = field.Site("first-r1");
    CHECK(site["superseded_by"] == "later-r1");
    CHECK(site["superseded_at"] == kLaterText);
    CHECK(site["superseded_reason"] == reason);
    CHECK(site["superseded_detail"].get<std::string>().find(" m") != std::string::npos);
    CHECK(site["last_seen_at"] == "2020-09-13T12:26:40Z");
    const auto refused = field.client->Get("/v1/sites/first-r1?f=csv");
    CHECK(refused->body.find(site["superseded_detail"]) != std::string::npos);
    const auto kml = field.client->Get("/v1/sites/first-r1?f=kml&include=superseded");
    CHECK(kml->body.find("SUPERSEDED") != std::string::npos);
  }
  CHECK(FieldServer({First(), Later(Ground::kTreeAside)}).IsServed());
}

TEST_CASE("memory: ground that is merely not recognised any more leaves the site unverified") {
  const FieldServer field({First(), Later(Ground::kHazardInDisc)});
  CHECK(field.IsServed());
  const nlohmann::json site = field.Site("first-r1");
  CAPTURE(site.dump());
  CHECK(site["verdict"] == "unverified");
  CHECK(site["doubted_by"] == "later");
  CHECK(site["doubted_at"] == kLaterText);
  CHECK(site["doubt_reason"] == "no_safe_touchdown");
  CHECK(site["doubt_detail"].get<std::string>().find(" m") != std::string::npos);
  CHECK(site["last_seen_at"] == "2020-09-13T12:26:40Z");
  CHECK_FALSE(site.contains("superseded_by"));
  const auto csv = field.client->Get("/v1/sites/first-r1?f=csv");
  CHECK(csv->body.find("unverified") != std::string::npos);
  const auto plan = field.client->Get("/v1/sites/first-r1?f=plan&home_altitude_m=300");
  CHECK(plan->body.find(kLaterText) != std::string::npos);
  // A later map on which the plan holds settles the doubt, in whichever order they arrive.
  const Flown doubting = Later(Ground::kHazardInDisc);
  const Flown free = Later(Ground::kFree, "latest", kLatest);
  for (const auto& flights :
       {std::vector<Flown>{First(), doubting, free}, std::vector<Flown>{free, doubting, First()}}) {
    CHECK_FALSE(FieldServer(flights).Site("first-r1").contains("doubted_by"));
  }
  // An earlier one does not.
  const Flown before = Later(Ground::kFree, "before", kLater - 1);
  CHECK(FieldServer({First(), doubting, before}).Site("first-r1").contains("doubted_by"));
}

TEST_CASE("memory: a doubted site ranks behind a sure one in lists, exports and recall") {
  Flown better = First();
  better.flight_id = "better";
  better.place = kPlace + 1;
  // Nearer to the aircraft.
  const FieldServer field({First(), Later(Ground::kHazardInDisc), better});
  const auto first_of = [&](const std::string& path, const char* list) {
    const nlohmann::json answer = GetJson(*field.client, path);
    CAPTURE(answer.dump());
    const nlohmann::json& first = answer[list][0];
    return first.contains("properties") ? first["properties"]["id"] : first["site_id"];
  };
  CHECK(first_of("/v1/sites?bbox=7.9,47.02,8.1,47.1", "features") == "better-r1");
  CHECK(first_of("/v1/emergency/export?bbox=7.9,47.02,8.1,47.1", "features") == "better-r1");
  const std::string recall =
      "/v1/emergency?latitude_deg=47.04&longitude_deg=8&altitude_m=2500&heading_deg=0"
      "&wind_east_mps=0&wind_north_mps=-4";
  CHECK(first_of(recall, "sites") == "better-r1");
  const nlohmann::json sites = GetJson(*field.client, recall)["sites"];
  const auto doubted = std::find_if(sites.begin(), sites.end(), [](const nlohmann::json& site) {
    return site["site_id"] == "first-r1";
  });
  REQUIRE(doubted != sites.end());
  CHECK((*doubted)["verdict"] == "unverified");
  CHECK((*doubted)["doubted_at"] == kLaterText);
  CHECK((*doubted)["warnings"].dump().find(kLaterText) != std::string::npos);
}

TEST_CASE("memory: a plan that is doubted only as it is asked for ranks behind a sure one") {
  Flown better = First();
  better.flight_id = "better";
  better.place = kPlace + 1;
  const FieldServer field({First(), Later(Ground::kHazardAside), better});
  CHECK_FALSE(field.Site("first-r1").contains("doubted_by"));
  // Nearer to the aircraft.
  const std::string recall =
      "/v1/emergency?latitude_deg=47.04&longitude_deg=8&altitude_m=2500&heading_deg=0"
      "&wind_east_mps=0&wind_north_mps=-4";
  CHECK(GetJson(*field.client, recall)["sites"][0]["site_id"] == "first-r1");
  const nlohmann::json sites =
      GetJson(*field.client, recall + "&touchdown_uncertainty_m=25")["sites"];
  CAPTURE(sites.dump());
  CHECK(sites[0]["site_id"] != "first-r1");
  CHECK(sites[0]["verdict"] == "landable");
  CHECK(sites.back()["site_id"] == "first-r1");
  CHECK(sites.back()["verdict"] == "unverified");
  CHECK(sites.back()["warnings"].dump().find("not recognised") != std::string::npos);
}

TEST_CASE("memory: what superseded a site is forgotten: the other later maps decide again") {
  const FieldServer field({First(),
                           Later(Ground::kTreeOnFinal),
                           Later(Ground::kTreeOnCircle, "latest", kLatest),
                           Later(Ground::kFree, "free", kLater + 1)});
  CHECK(field.Site("first-r1")["superseded_by"] == "latest-r1");
  // The map of a deleted site stays.
  CHECK(field.client->Delete("/v1/sites/latest-r1")->status == 204);
  CHECK(field.Site("first-r1")["superseded_by"] == "latest");
  CHECK(field.Forget("latest") == 204);
  CHECK_FALSE(field.IsServed());
  CHECK(field.Site("first-r1")["superseded_by"] == "later-r1");
  CHECK(field.Site("first-r1")["superseded_reason"] == "approach_blocked");
  CHECK(field.Forget("later") == 204);
  CHECK(field.IsServed());
  CHECK_FALSE(field.Site("first-r1").contains("superseded_reason"));
  CHECK(field.Site("first-r1")["last_seen_at"] == kLaterText);
  CHECK(field.Forget("free") == 204);
  CHECK(field.Site("first-r1")["last_seen_at"] == "2020-09-13T12:26:40Z");
}

TEST_CASE("memory: altitudes of another datum, or wrong ones, change nothing of the ground") {
  for (const char* const datum : {"amsl", "unknown"}) {
    Flown higher = Later(Ground::kFree);
    higher.altitude_datum = datum;
    higher.altitude_error_m = 48.0;
    const FieldServer field({First(), higher});
    CHECK(field.IsServed());
    CHECK(field.Site("first-r1")["last_seen_at"] == kLaterText);
    higher.ground = Ground::kTreeOnFinal;
    CHECK_FALSE(FieldServer({First(), higher}).IsServed());
  }
}

TEST_CASE("memory: within a flight a new evaluation replaces what its old map said") {
  Flown again = Later(Ground::kFree);
  again.updated_at_us = 2;
  const FieldServer field({First(), Later(Ground::kTreeOnFinal), again});
  CHECK(field.IsServed());
  CHECK(field.Site("first-r1")["last_seen_at"] == kLaterText);
  // A map of the flight's own never supersedes.
  Flown own = Later(Ground::kTreeOnFinal, "first");
  own.region_id = 7;
  CHECK(FieldServer({First(), own}).IsServed());
}

// What is stored of the first flight's site once both are.
SiteRow After(const Flown& first, const Flown& later) {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  MapCache maps({size_t{1} << 24, size_t{1} << 22});
  Store(storage, maps, first);
  Store(storage, maps, later);
  return *storage.sites.Find(IdOf(first));
}

TEST_CASE("memory: a map across the antimeridian supersedes at its own place") {
  for (const double longitude_deg : {179.9999, -179.9999}) {
    CAPTURE(longitude_deg);
    Flown first = First(), later = Later(Ground::kTreeOnFinal);
    first.longitude_deg = longitude_deg;
    later.longitude_deg = longitude_deg;
    CHECK(After(first, later).superseded_by == "later-r1");
    later.ground = Ground::kFree;
    CHECK(After(first, later).confirmed_at_us == kLater);
  }
}

TEST_CASE("memory: far in the north, a new mast 1.7 km west of the touchdown supersedes the site") {
  Flown first = First();
  first.latitude_deg = 60.0;
  // Its final is 1.8 km long.
  first.approach_height_m = 400.0;
  first.wind = {-4.0, 0.0};
  Flown later = first;
  later.flight_id = "later";
  later.seen_at_us = kLater;
  later.is_accepted = false;
  later.ground = Ground::kTreeOnFinal;
  later.tree_m = 600.0;
  // The mast stands 30 m south of the middle.
  later.map_shift = {-1700.0, 30.0};
  const SiteRow after = After(first, later);
  CHECK(after.superseded_by == "later-r1");
  CHECK(after.superseded_reason == "approach_blocked");
}

}  // namespace
}  // namespace freelsd
