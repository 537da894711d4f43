// Every table, by SQL, as the role that servers act as.
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <libpq-fe.h>

#include "api/stored/stored.h"
#include "tests/server/meadow.h"
#include "tests/server/organisations/two_organisations.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

// They are the processes', without content; the servers need them whole.
const std::set<std::string> kTablesOfProcesses{
    "schema_migrations", "versions", "owners", "workers", "feed"};

class Session {
 public:
  explicit Session(const std::string& url) : connection_(PQconnectdb(url.c_str()), PQfinish) {}

  // The first column; the error's SQLSTATE instead, if it fails.
  std::vector<std::string> Ask(const std::string& sql) {
    const std::unique_ptr<PGresult, decltype(&PQclear)> result(
        PQexec(connection_.get(), sql.c_str()), PQclear);
    const ExecStatusType status = PQresultStatus(result.get());
    if (status != PGRES_TUPLES_OK && status != PGRES_COMMAND_OK) {
      return {PQresultErrorField(result.get(), PG_DIAG_SQLSTATE)};
    }
    std::vector<std::string> texts;
    texts.reserve(static_cast<std::size_t>(PQntuples(result.get())) + 1);
    for (int row = 0; row < PQntuples(result.get()); ++row) {
      texts.emplace_back(PQgetvalue(result.get(), row, 0));
    }
    if (status == PGRES_COMMAND_OK) texts.emplace_back(PQcmdTuples(result.get()));
    return texts;
  }
  std::string One(const std::string& sql) {
    const std::vector<std::string> texts = Ask(sql);
    return texts.empty() ? "" : texts.front();
  }

 private:
  std::unique_ptr<PGconn, decltype(&PQfinish)> connection_;
};

constexpr char kTables[] =
    "SELECT tablename FROM pg_tables WHERE schemaname = current_schema() ORDER BY 1";
constexpr char kNoRights[] = "42501";

std::string OwnerColumn(const std::string& table) {
  return table == "organisations" ? "name" : "organisation";
}

// A copy of one row of the owner's that anybody may read, and an INSERT of it into the table.
std::string InsertOfCopy(Session& session, const std::string& table) {
  session.One("CREATE TEMP TABLE copy_of_" + table + " AS SELECT * FROM " + table + " WHERE " +
              OwnerColumn(table) + " = 'north' LIMIT 1");
  session.One("GRANT SELECT ON copy_of_" + table + " TO freelsd_app");
  const std::string columns = session.One(
      "SELECT string_agg(column_name, ', ') FROM information_schema.columns WHERE table_schema = "
      "current_schema() AND table_name = '" +
      table + "' AND is_generated = 'NEVER' AND is_identity = 'NO'");
  return "INSERT INTO " + table + " (" + columns + ") SELECT " + columns + " FROM copy_of_" + table;
}

// In a transaction that is rolled back.
std::string In(Session& session, const std::string& organisation, const std::string& sql) {
  session.One("BEGIN");
  session.One("SET LOCAL ROLE freelsd_app");
  if (!organisation.empty()) {
    session.One("SELECT set_config('freelsd.organisation', '" + organisation + "', true)");
  }
  std::string answer = session.One(sql);
  session.One("ROLLBACK");
  return answer;
}

void CheckTable(Session& session, const std::string& table) {
  CAPTURE(table);
  const std::string column = OwnerColumn(table);
  const std::string of_north = " WHERE " + column + " = 'north'";
  // Otherwise the rest would say nothing.
  REQUIRE(In(session, "north", "SELECT count(*) > 0 FROM " + table + of_north) == "t");
  const std::string insert = InsertOfCopy(session, table);
  for (const std::string& who : {std::string("south"), std::string()}) {
    CAPTURE(who);
    CHECK(In(session, who, "SELECT count(*) FROM " + table + " WHERE " + column + " <> 'south'") ==
          "0");
    CHECK(In(session, who, "UPDATE " + table + " SET " + column + " = " + column + of_north) ==
          "0");
    CHECK(In(session, who, "DELETE FROM " + table + of_north) == "0");
    CHECK(In(session, who, insert) == kNoRights);
  }
  CHECK(In(session, "", "SELECT count(*) FROM " + table) == "0");
}

TEST_SUITE("postgresql" * doctest::skip()) {
  TEST_CASE("organisations: no table shows or takes rows of another organisation") {
    const TwoOrganisations two;
    two.north->claims.Tell({0, "frame", "north-flight", "{}", "north"});
    two.place.Execute(
        "INSERT INTO claims (flight_id, organisation) VALUES ('north-flight', 'north')");
    Session session(two.place.options().database_url);
    int num_checked = 0;
    for (const std::string& table : session.Ask(kTables)) {
      if (kTablesOfProcesses.contains(table)) continue;
      CheckTable(session, table);
      ++num_checked;
    }
    CHECK(num_checked == 21);
  }

  TEST_CASE(
      "organisations: who serves all of them sees work, claims and events, and changes no flight") {
    const TwoOrganisations two;
    Session session(two.place.options().database_url);
    const std::string all = "SELECT set_config('freelsd.all_organisations', 'on', true); ";
    CHECK(In(session, "south", all + "SELECT count(*) FROM flights") == "1");
    CHECK(In(session, "south", all + "SELECT count(*) FROM jobs") == "1");
    for (const char* const table :
         {"sites", "maps", "map_tiles", "obstacles", "telemetry", "images", "regions"}) {
      CAPTURE(table);
      CHECK(In(session, "south", all + "SELECT count(*) FROM " + table) == "0");
    }
    CHECK(In(session, "south", all + "UPDATE flights SET name = 'x'") == kNoRights);
    CHECK(In(session, "south", all + "UPDATE jobs SET stage = 'x'") == "0");
    CHECK(In(session, "south", all + "DELETE FROM flights") == "0");
  }

  TEST_CASE(
      "organisations: who shares lets others read its ground, and supersede only if they share") {
    const TwoOrganisations two;
    const std::unique_ptr<Storage> south = two.storage->ForOrganisation("south");
    CHECK(south->sites.List(std::nullopt, std::nullopt).empty());
    two.north->ShareSites(true);
    CHECK(south->sites.List(std::nullopt, std::nullopt).size() == 2);
    CHECK(south->maps.ListOf("north-flight").size() == 2);
    CHECK(south->obstacles.List().at(0).id == "north:north-mast");
    CHECK_FALSE(south->obstacles.Delete("north-mast"));
    CHECK_FALSE(south->flights.Find("north-flight"));
    Session session(two.place.options().database_url);
    CHECK(In(session, "south", "UPDATE sites SET is_checked = true") == "0");
    south->ShareSites(true);
    CHECK(In(session, "south", "UPDATE sites SET is_checked = true") == "2");
    CHECK(In(session, "south", "UPDATE sites SET score = 1") == kNoRights);
    CHECK(In(session, "south", "DELETE FROM sites") == "0");
  }

  TEST_CASE("organisations: sites are checked again on maps that others share from now on") {
    const TwoOrganisations two;
    const std::unique_ptr<Storage> south = two.storage->ForOrganisation("south");
    SiteRow site = MeadowSite("amsl");
    site.id = "south-old";
    PutOnMap(*south, site, Meadow());
    SiteRow far = site;
    far.id = "south-far";
    far.longitude_deg = 9.0;
    far.map_box = BoundingBox{8.99, 46.99, 9.01, 47.01};
    PutOnMap(*south, far, Meadow());
    Standing checked;
    checked.is_checked = true;
    south->sites.TakeTurn()->SetStandings({{"south-old", checked}, {"south-far", checked}});
    REQUIRE(south->sites.ListUnchecked().empty());
    two.north->ShareSites(true);
    CHECK(south->sites.ListUnchecked() == std::vector<std::string>{"south-old"});
  }

  TEST_CASE("organisations: the bounds of what may be recalled are those of what is seen") {
    const TwoOrganisations two;
    const std::unique_ptr<Storage> south = two.storage->ForOrganisation("south");
    CHECK(south->sites.BoundsOfRecallable().aircraft_jsons.empty());
    const RecallBounds of_north = two.north->sites.BoundsOfRecallable();
    CHECK(of_north.aircraft_jsons.size() == 1);
    two.north->ShareSites(true);
    CHECK(south->sites.BoundsOfRecallable().aircraft_jsons == of_north.aircraft_jsons);
    CHECK(south->sites.BoundsOfRecallable().min_altitude_m == of_north.min_altitude_m);
    CHECK(south->changes.LastNumber() == 0);
    CHECK(two.north->changes.LastNumber() > 0);
  }

  TEST_CASE("organisations: places are found by index below row-level security") {
    const TwoOrganisations two;
    Session session(two.place.options().database_url);
    session.One("SET enable_seqscan = off");
    session.One("BEGIN");
    session.One("SET LOCAL ROLE freelsd_app");
    session.One("SELECT set_config('freelsd.organisation', 'north', true)");
    std::string plan;
    for (const std::string& line :
         session.Ask("EXPLAIN WITH wanted AS MATERIALIZED (SELECT ST_MakeEnvelope(w, 46, 9, 48, "
                     "4326) AS envelope FROM unnest(ARRAY[7.0::float8]) AS w) SELECT site_id FROM "
                     "wanted JOIN site_areas ON area && envelope")) {
      plan += line + "\n";
    }
    CHECK_MESSAGE(plan.find("site_areas_by_place") != std::string::npos, plan);
  }

  TEST_CASE(
      "organisations: the same image of two is stored twice, and one's removal leaves the "
      "other's") {
    const TwoOrganisations two;
    const std::unique_ptr<Storage> south = two.storage->ForOrganisation("south");
    const std::string image = NoiseImage(1);
    const std::string sha256 = Sha256Hex(image);
    CHECK(two.north->images.Read(sha256));
    CHECK_FALSE(south->images.Read(sha256));
    south->images.Write(sha256, image);
    CHECK(south->images.NumBytes() == image.size());
    south->images.RemoveUnused(sha256);
    CHECK_FALSE(south->images.Read(sha256));
    CHECK(two.north->images.Read(sha256) == image);
    CHECK(std::filesystem::exists(two.place.images_folder() / "organisations" / "north"));
  }
}

}  // namespace
}  // namespace freelsd
