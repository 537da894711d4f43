#include "storage/sqlite/site_queries.h"

#include <algorithm>

#include "storage/boxes.h"
#include "storage/checksum.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

int64_t ChecksumOf(const SiteRow& site) {
  Checksum checksum;
  checksum.Add(site.map_id);
  if (site.seen_until_us) checksum.Add(*site.seen_until_us);
  return checksum.Add(site.id)
      .Add(site.flight_id)
      .Add(site.region_id)
      .Add(site.latitude_deg)
      .Add(site.longitude_deg)
      .Add(site.feature_json)
      .Add(site.approach_json)
      .Add(site.replan_json)
      .Add(site.updated_at_us)
      .Add(site.seen_at_us)
      .value();
}

int64_t ChecksumOf(const RecallRow& row) {
  Checksum checksum;
  checksum.Add(row.map_id);
  if (row.seen_until_us) checksum.Add(*row.seen_until_us);
  return checksum.Add(row.site_id)
      .Add(row.latitude_deg)
      .Add(row.longitude_deg)
      .Add(row.updated_at_us)
      .Add(row.seen_at_us)
      .Add(static_cast<int64_t>(row.data.is_landable))
      .Add(row.data.altitude_m)
      .Add(row.data.altitude_datum)
      .Add(row.data.score)
      .Add(row.data.aircraft_json)
      .value();
}

// A row without a checksum is not checked: a bench that writes rows itself computes none.
template <typename Checked>
void Check(const Checked& read, const Row& row, int column) {
  const std::optional<int64_t> stored = row.OptionalInt(column);
  if (!stored || *stored == ChecksumOf(read)) return;
  throw StorageError("read a site", "its checksum is wrong", StorageFault::kDamaged);
}

SiteRow CheckedSiteOf(const Row& row) {
  SiteRow site = SiteRowOf(row);
  Check(site, row, kNumSiteColumns);
  return site;
}

std::string SelectSites(const std::string& which) {
  return std::string("SELECT ") + kSiteColumns + ", checksum FROM sites " + which;
}

const std::string kRecallColumns =
    "sites.id, flight_id, latitude_deg, longitude_deg, updated_at_us, seen_at_us, is_landable, "
    "altitude_m, altitude_datum, score, aircraft_json, site_numbers.checksum, confirmed_at_us, "
    "map_id, seen_until_us";
constexpr int kNumRecallColumns = 15;

RecallRow RecallRowOf(const Row& row) {
  RecallRow site;
  site.site_id = row.Text(0);
  site.flight_id = row.Text(1);
  site.latitude_deg = row.Real(2);
  site.longitude_deg = row.Real(3);
  site.updated_at_us = row.Int(4);
  site.seen_at_us = row.Int(5);
  site.data = {row.Bool(6), row.Real(7), row.Text(8), row.Real(9), row.Text(10)};
  site.map_id = row.Text(13);
  site.seen_until_us = row.OptionalInt(14);
  Check(site, row, 11);
  // Changed only after the checksum was compared, because the checksum covers the stored value.
  site.seen_at_us = std::max(site.seen_at_us, row.OptionalInt(12).value_or(site.seen_at_us));
  return site;
}

void PutSiteRow(Database& writer, const SiteRow& site) {
  writer.Change(
      "INSERT INTO sites (id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, "
      "approach_json, replan_json, updated_at_us, checksum, seen_at_us, map_id, seen_until_us) "
      "VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13) ON CONFLICT (id) "
      "DO UPDATE SET flight_id = $2, region_id = $3, latitude_deg = $4, longitude_deg = $5, "
      "feature_json = $6, approach_json = $7, replan_json = $8, updated_at_us = $9, "
      "checksum = $10, seen_at_us = $11, map_id = $12, seen_until_us = $13",
      site.id,
      site.flight_id,
      site.region_id,
      site.latitude_deg,
      site.longitude_deg,
      site.feature_json,
      site.approach_json,
      site.replan_json,
      site.updated_at_us,
      ChecksumOf(site),
      site.seen_at_us,
      site.map_id,
      site.seen_until_us);
}

void PutBox(Database& writer, const SiteRow& site) {
  const BoundingBox touchdown{
      site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg};
  const BoundingBox box = Unrolled(site.map_box.value_or(touchdown));
  writer.Change("INSERT OR REPLACE INTO site_boxes VALUES ($1, $2, $3, $4, $5)",
                writer.Int("SELECT number FROM site_numbers WHERE site_id = $1", site.id),
                box.west_deg,
                box.east_deg,
                box.south_deg,
                box.north_deg);
}

void PutRecall(Database& writer, const SiteRow& site) {
  RecallData data = site.recall.value_or(RecallData{});
  if (!site.recall) data.altitude_datum = site.map_datum;
  const RecallRow row{site.id,
                      site.flight_id,
                      site.map_id,
                      site.latitude_deg,
                      site.longitude_deg,
                      site.updated_at_us,
                      site.seen_at_us,
                      data,
                      site.seen_until_us};
  writer.Change(
      "INSERT INTO site_numbers (site_id, is_recallable, is_landable, altitude_m, "
      "altitude_datum, score, aircraft_json, checksum) VALUES ($1, $2, $3, $4, $5, $6, $7, $8) "
      "ON CONFLICT (site_id) DO UPDATE SET is_recallable = $2, is_landable = $3, "
      "altitude_m = $4, altitude_datum = $5, score = $6, aircraft_json = $7, checksum = $8",
      site.id,
      site.recall.has_value(),
      data.is_landable,
      data.altitude_m,
      data.altitude_datum,
      data.score,
      data.aircraft_json,
      ChecksumOf(row));
}

// Calls `visit` for each row whose box in site_boxes meets `box`, which may cross the antimeridian.
// `select` ends with conditions and AND.
template <typename Visit>
void ForEachMeeting(Database& database,
                    const std::string& select,
                    const BoundingBox& box,
                    const Visit& visit) {
  const std::string query = select +
                            " site_boxes.west_deg > $1 AND site_boxes.west_deg <= $2 AND "
                            "site_boxes.east_deg >= $3 AND site_boxes.north_deg >= $4 AND "
                            "site_boxes.south_deg <= $5";
  for (const auto& [west_above_deg, west_up_to_deg, east_from_deg] : SearchesFor(box)) {
    database.Select(query,
                    {west_above_deg, west_up_to_deg, east_from_deg, box.south_deg, box.north_deg},
                    [&visit](const Row& row) {
                      visit(row);
                      return true;
                    });
  }
}

std::optional<SiteRow> FindSiteRow(Database& database, const std::string& site_id) {
  return database.First(CheckedSiteOf, SelectSites("WHERE id = $1"), site_id);
}

std::vector<SiteRow> ListSiteRows(Database& database,
                                  const std::optional<std::string>& flight_id,
                                  const BoundingBox& box) {
  return database.Each(
      CheckedSiteOf,
      SelectSites("WHERE ($1 = false OR flight_id = $2) AND latitude_deg BETWEEN $3 AND $5 AND ("
                  "CASE WHEN $4 <= $6 THEN longitude_deg BETWEEN $4 AND $6 "
                  "ELSE longitude_deg >= $4 OR longitude_deg <= $6 END) ORDER BY id"),
      flight_id.has_value(),
      flight_id.value_or(""),
      box.south_deg,
      box.west_deg,
      box.north_deg,
      box.east_deg);
}

std::vector<std::string> ListAcceptedIds(Database& database, const BoundingBox& box) {
  std::vector<std::string> ids;
  ForEachMeeting(database,
                 "SELECT site_id FROM site_boxes JOIN site_numbers USING (number) "
                 "JOIN sites ON sites.id = site_id "
                 "WHERE (is_recallable = 1 OR approach_json <> '') AND",
                 box,
                 [&ids](const Row& row) { ids.push_back(row.Text(0)); });
  return ids;
}

RecallBounds FindBounds(Database& database) {
  RecallBounds bounds;
  bounds.min_altitude_m =
      *database.First([](const Row& row) { return row.Real(0); },
                      "SELECT coalesce(min(altitude_m), 0) FROM site_numbers WHERE is_recallable = "
                      "1");
  // One search of an index for each aircraft: many sites are of the same.
  bounds.aircraft_jsons = database.Texts(
      "WITH RECURSIVE found (json) AS (SELECT min(aircraft_json) FROM site_numbers "
      "WHERE is_recallable = 1 UNION ALL SELECT (SELECT min(aircraft_json) FROM site_numbers "
      "WHERE is_recallable = 1 AND aircraft_json > json) FROM found WHERE json IS NOT NULL) "
      "SELECT json FROM found WHERE json IS NOT NULL");
  return bounds;
}

BoxCache<RecallRow>::Rows ListRecallRows(Database& database, const BoundingBox& box) {
  BoxCache<RecallRow>::Rows rows;
  ForEachMeeting(
      database,
      "SELECT " + kRecallColumns + ", west_deg, south_deg, east_deg, north_deg, " +
          kStandingColumns +
          " FROM site_boxes JOIN site_numbers USING (number) JOIN sites ON sites.id = site_id "
          "WHERE is_recallable = 1 AND superseded_by IS NULL AND",
      box,
      [&rows](const Row& row) {
        RecallRow site = RecallRowOf(row);
        const Standing standing = StandingAt(row, kNumRecallColumns + 4);
        if (standing.IsDoubted()) site.doubt = std::make_shared<const Standing>(standing);
        rows.push_back({Rolled(BoxAt(row, kNumRecallColumns)),
                        std::make_shared<const RecallRow>(std::move(site))});
      });
  return rows;
}

BoxCache<MapRow>::Rows ListMapRows(Database& database, const BoundingBox& box) {
  BoxCache<MapRow>::Rows rows;
  ForEachMapRow(database,
                "WHERE is_in_force = 1 AND south_deg <= $4 AND north_deg >= $2 AND CASE "
                "WHEN west_deg <= east_deg THEN west_deg <= $3 AND east_deg >= $1 "
                "ELSE west_deg <= $3 OR east_deg >= $1 END ORDER BY id",
                {box.west_deg, box.south_deg, box.east_deg, box.north_deg},
                [&rows](const FlightMapRow& map) {
                  rows.push_back({map.box, std::make_shared<const MapRow>(RowOf(map))});
                });
  return rows;
}

BoxCache<std::string>::Rows ListOverruledIds(Database& database, const BoundingBox& box) {
  BoxCache<std::string>::Rows rows;
  ForEachMeeting(
      database,
      // CROSS JOIN fixes the order: few sites are superseded, but many may lie in the box.
      "SELECT sites.id, west_deg, south_deg, east_deg, north_deg FROM sites "
      "CROSS JOIN site_numbers ON site_id = sites.id CROSS JOIN site_boxes USING (number) "
      "WHERE superseded_by IS NOT NULL AND is_recallable = 1 AND",
      box,
      [&rows](const Row& row) {
        rows.push_back({Rolled(BoxAt(row, 1)), std::make_shared<const std::string>(row.Text(0))});
      });
  return rows;
}

}  // namespace

void PutSiteRows(Database& writer, const SiteRow& site) {
  PutSiteRow(writer, site);
  PutStandings(writer, {{site.id, site}});
  PutRecall(writer, site);
  PutBox(writer, site);
}

std::optional<SiteRow> FindWholeSiteRow(Database& database, const std::string& site_id) {
  std::optional<SiteRow> site = FindSiteRow(database, site_id);
  if (!site) return std::nullopt;
  const auto complete = [&site](const Row& row) {
    const RecallData data = RecallRowOf(row).data;
    site->map_datum = data.altitude_datum;
    if (row.Bool(kNumRecallColumns)) site->recall = data;
    site->map_box = Rolled(BoxAt(row, kNumRecallColumns + 1));
    return false;
  };
  database.Select("SELECT " + kRecallColumns +
                      ", is_recallable, west_deg, south_deg, east_deg, north_deg FROM site_numbers "
                      "JOIN sites ON sites.id = site_id JOIN site_boxes USING (number) "
                      "WHERE site_id = $1",
                  {site_id},
                  complete);
  return site;
}

bool DeleteSiteRows(Database& writer, const std::string& site_id) {
  // An R*Tree has no foreign keys.
  writer.Change(
      "DELETE FROM site_boxes WHERE number IN (SELECT number FROM site_numbers WHERE site_id = $1)",
      site_id);
  return writer.Change("DELETE FROM sites WHERE id = $1", site_id) > 0;
}

void CheckSiteRows(Database& database) {
  database.Select(SelectSites(""), {}, [](const Row& row) {
    CheckedSiteOf(row);
    return true;
  });
  const auto check = [](const Row& row) {
    if (row.IsNull(kNumRecallColumns)) {
      throw StorageError("read a site", "it has no bounding box", StorageFault::kDamaged);
    }
    RecallRowOf(row);
    return true;
  };
  database.Select("SELECT " + kRecallColumns +
                      ", site_boxes.number FROM sites LEFT JOIN site_numbers "
                      "ON site_id = sites.id LEFT JOIN site_boxes USING (number)",
                  {},
                  check);
}

const SiteQueries kSqliteSites{PutSiteRows,
                               DeleteSiteRows,
                               FindSiteRow,
                               FindWholeSiteRow,
                               ListSiteRows,
                               ListAcceptedIds,
                               FindBounds,
                               ListRecallRows,
                               ListMapRows,
                               ListOverruledIds};

}  // namespace freelsd
