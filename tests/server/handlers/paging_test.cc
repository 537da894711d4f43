// Pages of flights, jobs and sites.
#include <chrono>
#include <set>

#include <doctest/doctest.h>
#include <sqlite3.h>

#include "tests/server/meadow.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

// Every page from the first to the last; checks that only the last has no `next`.
std::vector<nlohmann::json> Pages(httplib::Client& client,
                                  const std::string& path,
                                  const std::function<void()>& between = {}) {
  std::vector<nlohmann::json> pages;
  std::string cursor;
  do {
    pages.push_back(GetJson(client, path + cursor));
    const nlohmann::json& next = pages.back().value("next", nlohmann::json());
    cursor = next.is_string() ? "&cursor=" + next.get<std::string>() : "";
    if (between) between();
  } while (!cursor.empty() && pages.size() < 100);
  return pages;
}

std::vector<std::string> IdsOf(const std::vector<nlohmann::json>& pages, const std::string& name) {
  std::vector<std::string> ids;
  for (const nlohmann::json& page : pages) {
    for (const nlohmann::json& item : page.at(name)) ids.push_back(item.at("id"));
  }
  return ids;
}

TEST_CASE("paging: the pages of flights list each flight once, also while new ones arrive") {
  constexpr int kNumFlights = 7;
  FreshServer fresh;
  std::vector<std::string> newest_first;
  for (int i = 0; i < kNumFlights; ++i) {
    newest_first.insert(newest_first.begin(), NewFlight(fresh.client));
  }
  CHECK(IdsOf({GetJson(fresh.client, "/v1/flights")}, "flights") == newest_first);
  const auto pages =
      Pages(fresh.client, "/v1/flights?limit=3", [&fresh] { NewFlight(fresh.client); });
  CHECK(pages.size() == 3);
  CHECK(IdsOf(pages, "flights") == newest_first);
  // A limit that is just met leaves no empty last page.
  CHECK(Pages(fresh.client, "/v1/flights?limit=10").size() == 1);
}

TEST_CASE("paging: the pages of jobs list each job once") {
  FreshServer fresh;
  std::vector<std::string> newest_first;
  for (int i = 0; i < 5; ++i) {
    const auto job = fresh.client.Post("/v1/flights/" + NewFlight(fresh.client) + "/finish");
    newest_first.insert(newest_first.begin(), nlohmann::json::parse(job->body)["id"]);
  }
  CHECK(IdsOf(Pages(fresh.client, "/v1/jobs?limit=2"), "jobs") == newest_first);
  CHECK(IdsOf(Pages(fresh.client, "/v1/jobs?limit=5"), "jobs") == newest_first);
}

// Six sites at the meadow's place, of three verdicts.
void StoreSites(Storage& storage) {
  const char* const verdicts[] = {"rejected", "unverified", "landable"};
  for (int i = 0; i < 6; ++i) {
    SiteRow site = MeadowSite();
    site.id = "s-r" + std::to_string(i);
    nlohmann::json feature = nlohmann::json::parse(site.feature_json);
    feature["id"] = site.id;
    feature["properties"]["id"] = site.id;
    feature["properties"]["verdict"] = verdicts[i % 3];
    feature["properties"]["score"] = 1.0 / (i + 3);
    site.feature_json = feature.dump();
    PutWithoutMap(storage, site);
  }
}

// Ages grow from request to request.
nlohmann::json Ageless(nlohmann::json feature) {
  feature["properties"].erase("age_s");
  return feature;
}

TEST_CASE("paging: the pages of sites are the parts of the whole ranked list") {
  MeadowServer meadow(StoreSites);
  nlohmann::json whole = GetJson(*meadow.client, "/v1/sites")["features"];
  REQUIRE(whole.size() == 8);
  for (nlohmann::json& feature : whole) feature = Ageless(feature);
  CHECK(whole[0]["properties"]["verdict"] == "landable");
  for (const int limit : {1, 3, 8}) {
    CAPTURE(limit);
    nlohmann::json joined = nlohmann::json::array();
    for (const nlohmann::json& page :
         Pages(*meadow.client, "/v1/sites?limit=" + std::to_string(limit))) {
      for (const nlohmann::json& feature : page["features"]) joined.push_back(Ageless(feature));
    }
    // Ranks included.
    CHECK(joined == whole);
  }
  const nlohmann::json first = GetJson(*meadow.client, "/v1/sites?limit=3");
  // The site at the end of a page may be deleted before the next page is asked for.
  const std::string last = first["features"][2]["properties"]["id"];
  CHECK(meadow.client->Delete("/v1/sites/" + last)->status == 204);
  const nlohmann::json second =
      GetJson(*meadow.client, "/v1/sites?limit=3&cursor=" + first["next"].get<std::string>());
  CHECK(second["features"][0]["properties"]["id"] == whole[3]["properties"]["id"]);
}

TEST_CASE("paging: limits out of range and made-up cursors are refused by name") {
  MeadowServer meadow;
  for (const std::string path : {"/v1/flights", "/v1/jobs", "/v1/sites"}) {
    CAPTURE(path);
    CheckProblem(meadow.client->Get(path + "?limit=0"), 422, "InvalidValue");
    CheckProblem(meadow.client->Get(path + "?limit=10001"), 422, "InvalidValue");
    CheckProblem(meadow.client->Get(path + "?limit=2.5"), 422, "InvalidValue");
    CheckProblem(meadow.client->Get(path + "?limit=1e3"), 422, "InvalidValue");
    CheckProblem(meadow.client->Get(path + "?limit=x"), 400, "InvalidQuery");
    for (const std::string cursor : {"x", "", "1~x", "0~1", "99999999999999999999"}) {
      CAPTURE(cursor);
      const auto result = meadow.client->Get(path + "?cursor=" + cursor);
      CheckProblem(result, 400, "InvalidQuery");
      CHECK(result->body.find("\"pointer\":\"cursor\"") != std::string::npos);
    }
  }
}

// Copies the only flight of a closed database.
void CopyFlight(const std::filesystem::path& file, int num_copies) {
  const std::string sql =
      "WITH RECURSIVE numbers(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM numbers WHERE n < " +
      std::to_string(num_copies) +
      ") INSERT INTO flights SELECT id || '-' || n, name, request_json, rig_json, warnings_json, "
      "stages_json, created_at_us, num_rejected_frames, has_failed, ground_altitude_m, "
      "has_retired_images FROM numbers, flights";
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open(file.c_str(), &database) == SQLITE_OK);
  REQUIRE(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(database);
}

TEST_CASE("paging: ten thousand flights are listed within seconds, and a page at once") {
  constexpr int kNumCopies = 10000;
  constexpr std::chrono::seconds kMaxWhole{7};
  constexpr std::chrono::milliseconds kMaxPage{500};
  const TemporaryFolder folder;
  {
    TestServer server(TestConfig(folder.path()));
    httplib::Client client = server.Client();
    NewFlight(client);
  }
  CopyFlight(folder.path() / "freelsd.db", kNumCopies);
  const TestServer server(TestConfig(folder.path()));
  // Without the check against the contract, which takes longer than the answer.
  httplib::Client client("127.0.0.1", server.port());
  client.set_read_timeout(60);
  const auto begin = std::chrono::steady_clock::now();
  const auto whole = client.Get("/v1/flights");
  CHECK(std::chrono::steady_clock::now() - begin < kMaxWhole);
  const nlohmann::json flights = nlohmann::json::parse(whole->body);
  CHECK(flights["flights"].size() == kLimits.answer.max_num_listed);
  // One more than a page holds.
  const std::string next = flights.at("next");
  const auto page_begin = std::chrono::steady_clock::now();
  CHECK(client.Get("/v1/flights?limit=100")->status == 200);
  CHECK(std::chrono::steady_clock::now() - page_begin < kMaxPage);
  const auto last = client.Get("/v1/flights?cursor=" + next);
  CHECK(nlohmann::json::parse(last->body)["flights"].size() == 1);
  CHECK_FALSE(nlohmann::json::parse(last->body).contains("next"));
}

}  // namespace
}  // namespace freelsd
