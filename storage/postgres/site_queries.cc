#include "storage/postgres/site_queries.h"

#include <algorithm>
#include <memory>

#include "storage/boxes.h"
#include "storage/postgres/area_rows.h"

namespace freelsd {
namespace {

Boxed<RecallRow> BoxedRecallRow(const Row& row) {
  RecallRow site;
  site.site_id = row.Text(0);
  site.flight_id = row.Text(1);
  site.map_id = row.Text(2);
  site.latitude_deg = row.Real(3);
  site.longitude_deg = row.Real(4);
  site.updated_at_us = row.Int(5);
  site.seen_at_us = std::max(row.Int(6), row.OptionalInt(7).value_or(row.Int(6)));
  site.data = {row.Bool(8), row.Real(9), row.Text(10), row.Real(11), row.Text(12)};
  site.seen_until_us = row.OptionalInt(17);
  const Standing standing = StandingAt(row, 18);
  if (standing.IsDoubted()) site.doubt = std::make_shared<const Standing>(standing);
  return {BoxAt(row, 13), std::make_shared<const RecallRow>(std::move(site))};
}

Boxed<MapRow> BoxedMapRow(const Row& row) {
  return {BoxAt(row, 5),
          std::make_shared<const MapRow>(
              MapRow{row.Text(0), row.Text(1), row.Text(2), row.Int(3), row.OptionalInt(4)})};
}

constexpr char kRecallColumns[] =
    "is_recallable, is_landable, altitude_m, altitude_datum, score, aircraft_json, west_deg, "
    "south_deg, east_deg, north_deg";

SiteRow WholeSiteRowOf(const Row& row) {
  constexpr int kFirst = kNumSiteColumns;
  SiteRow site = SiteRowOf(row);
  site.map_datum = row.Text(kFirst + 3);
  if (row.Bool(kFirst)) {
    site.recall = RecallData{row.Bool(kFirst + 1),
                             row.Real(kFirst + 2),
                             row.Text(kFirst + 3),
                             row.Real(kFirst + 4),
                             row.Text(kFirst + 5)};
  }
  site.map_box = BoxAt(row, kFirst + 6);
  return site;
}

void PutSite(Database& writer, const SiteRow& site) {
  RecallData data = site.recall.value_or(RecallData{});
  if (!site.recall) data.altitude_datum = site.map_datum;
  const BoundingBox touchdown{
      site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg};
  const BoundingBox box = site.map_box.value_or(touchdown);
  writer.Change(
      "INSERT INTO sites (id, flight_id, region_id, map_id, latitude_deg, longitude_deg, "
      "feature_json, approach_json, replan_json, updated_at_us, seen_at_us, is_recallable, "
      "is_landable, altitude_m, altitude_datum, score, aircraft_json, west_deg, south_deg, "
      "east_deg, north_deg, seen_until_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, "
      "$12, $13, $14, $15, $16, $17, $18, $19, $20, $21, $22) ON CONFLICT (id) DO "
      "UPDATE SET flight_id = $2, "
      "region_id = $3, map_id = $4, latitude_deg = $5, longitude_deg = $6, feature_json = $7, "
      "approach_json = $8, replan_json = $9, updated_at_us = $10, seen_at_us = $11, "
      "is_recallable = $12, is_landable = $13, altitude_m = $14, altitude_datum = $15, "
      "score = $16, aircraft_json = $17, west_deg = $18, south_deg = $19, east_deg = $20, "
      "north_deg = $21, seen_until_us = $22",
      site.id,
      site.flight_id,
      site.region_id,
      site.map_id,
      site.latitude_deg,
      site.longitude_deg,
      site.feature_json,
      site.approach_json,
      site.replan_json,
      site.updated_at_us,
      site.seen_at_us,
      site.recall.has_value(),
      data.is_landable,
      data.altitude_m,
      data.altitude_datum,
      data.score,
      data.aircraft_json,
      box.west_deg,
      box.south_deg,
      box.east_deg,
      box.north_deg,
      site.seen_until_us);
  PutArea(PostgresOf(writer), "site", site.id, box);
  PutStandings(writer, {{site.id, site}});
}

bool DeleteSite(Database& writer, const std::string& site_id) {
  return writer.Change("DELETE FROM sites WHERE id = $1", site_id) > 0;
}

std::string SelectSites(const std::string& which) {
  return std::string("SELECT ") + kSiteColumns + " FROM sites " + which;
}

std::optional<SiteRow> FindSite(Database& database, const std::string& site_id) {
  return database.First(SiteRowOf, SelectSites("WHERE id = $1"), site_id);
}

std::optional<SiteRow> FindWholeSite(Database& database, const std::string& site_id) {
  return database.First(
      WholeSiteRowOf,
      std::string("SELECT ") + kSiteColumns + ", " + kRecallColumns + " FROM sites WHERE id = $1",
      site_id);
}

std::vector<SiteRow> ListSites(Database& database,
                               const std::optional<std::string>& flight_id,
                               const BoundingBox& box) {
  // The index finds a few more than the box holds; the degrees decide.
  return database.Each(
      SiteRowOf,
      SelectSites("WHERE (NOT $1 OR flight_id = $2) AND latitude_deg BETWEEN $3 AND $5 AND CASE "
                  "WHEN $4 <= $6 THEN longitude_deg BETWEEN $4 AND $6 "
                  "ELSE longitude_deg >= $4 OR longitude_deg <= $6 END "
                  "AND (touchdown && ST_MakeEnvelope($4, $3, $7, $5, 4326) "
                  "OR touchdown && ST_MakeEnvelope($4 - 360, $3, $7 - 360, $5, 4326)) ORDER BY id"),
      flight_id.has_value(),
      flight_id.value_or(""),
      box.south_deg,
      box.west_deg,
      box.north_deg,
      box.east_deg,
      Unrolled(box).east_deg);
}

std::vector<std::string> ListAccepted(Database& database, const BoundingBox& box) {
  return SelectMeeting(PostgresOf(database),
                       "SELECT id FROM sites WHERE (is_recallable OR approach_json <> '') "
                       "AND id IN",
                       "site",
                       box)
      .Texts();
}

RecallBounds FindBounds(Database& database) {
  RecallBounds bounds;
  bounds.min_altitude_m =
      *database.First([](const Row& row) { return row.Real(0); },
                      "SELECT coalesce(min(altitude_m), 0) FROM sites WHERE is_recallable");
  // One search of an index for each aircraft: many sites are of the same.
  bounds.aircraft_jsons = database.Texts(
      "WITH RECURSIVE found AS ((SELECT aircraft_json COLLATE \"C\" AS json FROM sites "
      "WHERE is_recallable ORDER BY 1 LIMIT 1) UNION ALL SELECT (SELECT aircraft_json "
      "COLLATE \"C\" FROM sites WHERE is_recallable AND aircraft_json COLLATE \"C\" > "
      "json ORDER BY 1 LIMIT 1) FROM found WHERE json IS NOT NULL) "
      "SELECT json FROM found WHERE json IS NOT NULL");
  return bounds;
}

BoxCache<RecallRow>::Rows SelectRecallRows(Database& database, const BoundingBox& box) {
  return SelectMeeting(
             PostgresOf(database),
             "SELECT id, flight_id, map_id, latitude_deg, longitude_deg, updated_at_us, "
             "seen_at_us, confirmed_at_us, is_landable, altitude_m, altitude_datum, score, "
             "aircraft_json, west_deg, south_deg, east_deg, north_deg, seen_until_us, "
             "superseded_by, superseded_at_us, superseded_reason, superseded_detail, "
             "confirmed_at_us, superseded_by_map FROM sites "
             "WHERE is_recallable AND superseded_by IS NULL AND id IN",
             "site",
             box)
      .Each(BoxedRecallRow);
}

BoxCache<std::string>::Rows SelectOverruledIds(Database& database, const BoundingBox& box) {
  return SelectMeeting(PostgresOf(database),
                       "SELECT id, west_deg, south_deg, east_deg, north_deg FROM sites "
                       "WHERE superseded_by IS NOT NULL AND is_recallable AND id IN",
                       "site",
                       box)
      .Each([](const Row& row) {
        return Boxed<std::string>{BoxAt(row, 1), std::make_shared<const std::string>(row.Text(0))};
      });
}

BoxCache<MapRow>::Rows SelectMapRows(Database& database, const BoundingBox& box) {
  return SelectMeeting(PostgresOf(database),
                       "SELECT id, flight_id, altitude_datum, seen_at_us, seen_until_us, "
                       "west_deg, south_deg, east_deg, north_deg FROM maps "
                       "WHERE is_in_force AND id IN",
                       "map",
                       box)
      .Each(BoxedMapRow);
}

}  // namespace

const SiteQueries kPostgresSites{PutSite,
                                 DeleteSite,
                                 FindSite,
                                 FindWholeSite,
                                 ListSites,
                                 ListAccepted,
                                 FindBounds,
                                 SelectRecallRows,
                                 SelectMapRows,
                                 SelectOverruledIds};

}  // namespace freelsd
