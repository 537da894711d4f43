#include "storage/sqlite/site_queries.h"

#include <algorithm>

#include "storage/boxes.h"
#include "storage/sqlite/checksum.h"
#include "storage/sqlite/site_standings.h"
#include "storage/storage_error.h"

namespace freelsd {
namespace {

constexpr BoundingBox kWholeEarth{-180.0, -90.0, 180.0, 90.0};

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
template <typename Row>
Row Checked(const Row& row, const Statement& statement, int column) {
  const std::optional<int64_t> stored = statement.OptionalInt(column);
  if (stored && *stored != ChecksumOf(row)) {
    throw StorageError("read a site", "its checksum is wrong", StorageFault::kDamaged);
  }
  return row;
}

SiteRow SiteRowOf(const Statement& statement) {
  SiteRow site;
  site.id = statement.Text(0);
  site.flight_id = statement.Text(1);
  site.region_id = statement.Int(2);
  site.latitude_deg = statement.Real(3);
  site.longitude_deg = statement.Real(4);
  site.feature_json = statement.Text(5);
  site.approach_json = statement.Text(6);
  site.replan_json = statement.Text(7);
  site.updated_at_us = statement.Int(8);
  site.seen_at_us = statement.Int(10);
  site.map_id = statement.Text(11);
  site.seen_until_us = statement.OptionalInt(12);
  static_cast<Standing&>(site) = StandingAt(statement, 13);
  return Checked(site, statement, 9);
}

Statement SelectSites(const Connection& connection, const std::string& which) {
  const std::string select =
      "SELECT id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json, "
      "replan_json, updated_at_us, checksum, seen_at_us, map_id, seen_until_us, " +
      std::string(kStandingColumns) + " FROM sites ";
  return connection.Prepare((select + which).c_str());
}

// Of a row of site_boxes.
BoundingBox BoxOf(const Statement& statement, int first_column) {
  return Rolled({statement.Real(first_column),
                 statement.Real(first_column + 1),
                 statement.Real(first_column + 2),
                 statement.Real(first_column + 3)});
}

RecallRow RecallRowOf(const Statement& statement) {
  RecallRow row;
  row.site_id = statement.Text(0);
  row.flight_id = statement.Text(1);
  row.latitude_deg = statement.Real(2);
  row.longitude_deg = statement.Real(3);
  row.updated_at_us = statement.Int(4);
  row.seen_at_us = statement.Int(5);
  row.data = {statement.Int(6) != 0,
              statement.Real(7),
              statement.Text(8),
              statement.Real(9),
              statement.Text(10)};
  row.map_id = statement.Text(13);
  row.seen_until_us = statement.OptionalInt(14);
  row = Checked(row, statement, 11);
  // Changed only after the checksum was compared, because the checksum covers the stored value.
  row.seen_at_us = std::max(row.seen_at_us, statement.OptionalInt(12).value_or(row.seen_at_us));
  return row;
}

void PutSiteRow(const Connection& writer, const SiteRow& site) {
  writer
      .Prepare(
          "INSERT INTO sites (id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, "
          "approach_json, replan_json, updated_at_us, checksum, seen_at_us, map_id, "
          "seen_until_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, "
          "nullif(?13, 0)) ON CONFLICT (id) DO UPDATE SET "
          "flight_id = ?2, region_id = ?3, latitude_deg = ?4, longitude_deg = ?5, feature_json = "
          "?6, approach_json = ?7, "
          "replan_json = ?8, updated_at_us = ?9, checksum = ?10, seen_at_us = ?11, map_id = ?12, "
          "seen_until_us = nullif(?13, 0)")
      .Bind(site.id,
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
            site.seen_until_us.value_or(0))
      .Run();
}

int64_t NumberOf(const Connection& writer, const std::string& site_id) {
  Statement statement = writer.Prepare("SELECT number FROM site_numbers WHERE site_id = ?1");
  statement.Bind(site_id).Step();
  return statement.Int(0);
}

void PutBox(const Connection& writer, const SiteRow& site) {
  const BoundingBox touchdown{
      site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg};
  const BoundingBox box = Unrolled(site.map_box.value_or(touchdown));
  writer.Prepare("INSERT OR REPLACE INTO site_boxes VALUES (?1, ?2, ?3, ?4, ?5)")
      .Bind(NumberOf(writer, site.id), box.west_deg, box.east_deg, box.south_deg, box.north_deg)
      .Run();
}

void PutRecall(const Connection& writer, const SiteRow& site) {
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
  writer
      .Prepare(
          "INSERT INTO site_numbers (site_id, is_recallable, is_landable, altitude_m, "
          "altitude_datum, score, aircraft_json, checksum) "
          "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8) ON CONFLICT (site_id) DO UPDATE SET "
          "is_recallable = ?2, is_landable = ?3, altitude_m = ?4, altitude_datum = ?5, score = ?6, "
          "aircraft_json = ?7, checksum = ?8")
      .Bind(site.id,
            static_cast<int>(site.recall.has_value()),
            static_cast<int>(data.is_landable),
            data.altitude_m,
            data.altitude_datum,
            data.score,
            data.aircraft_json,
            ChecksumOf(row))
      .Run();
}

}  // namespace

void PutSiteRows(const Connection& writer, const SiteRow& site) {
  PutSiteRow(writer, site);
  PutStandings(writer, {{site.id, site}});
  PutRecall(writer, site);
  PutBox(writer, site);
}

std::optional<SiteRow> FindSiteRow(const Connection& connection, const std::string& site_id) {
  Statement statement = SelectSites(connection, "WHERE id = ?1");
  if (!statement.Bind(site_id).Step()) return std::nullopt;
  return SiteRowOf(statement);
}

std::optional<SiteRow> FindWholeSiteRow(const Connection& connection, const std::string& site_id) {
  std::optional<SiteRow> found = FindSiteRow(connection, site_id);
  if (!found) return std::nullopt;
  SiteRow site = std::move(*found);
  Statement recall = connection.Prepare(
      "SELECT sites.id, flight_id, latitude_deg, longitude_deg, updated_at_us, seen_at_us, "
      "is_landable, altitude_m, altitude_datum, score, aircraft_json, site_numbers.checksum, "
      "confirmed_at_us, map_id, seen_until_us, is_recallable, west_deg, south_deg, east_deg, "
      "north_deg FROM site_numbers JOIN sites ON sites.id = site_id "
      "JOIN site_boxes USING (number) WHERE site_id = ?1");
  if (!recall.Bind(site_id).Step()) return site;
  const RecallData data = RecallRowOf(recall).data;
  site.map_datum = data.altitude_datum;
  if (recall.Int(15) != 0) site.recall = data;
  site.map_box = BoxOf(recall, 16);
  return site;
}

std::vector<SiteRow> ListSiteRows(const Connection& connection,
                                  const std::optional<std::string>& flight_id,
                                  const std::optional<BoundingBox>& box) {
  Statement statement =
      SelectSites(connection,
                  "WHERE (?1 = 0 OR flight_id = ?2) AND latitude_deg BETWEEN ?3 AND ?5 AND ("
                  "CASE WHEN ?4 <= ?6 THEN longitude_deg BETWEEN ?4 AND ?6 "
                  "ELSE longitude_deg >= ?4 OR longitude_deg <= ?6 END) ORDER BY id");
  const BoundingBox& wanted = box ? *box : kWholeEarth;
  statement.Bind(static_cast<int>(flight_id.has_value()),
                 flight_id.value_or(""),
                 wanted.south_deg,
                 wanted.west_deg,
                 wanted.north_deg,
                 wanted.east_deg);
  std::vector<SiteRow> sites;
  while (statement.Step()) sites.push_back(SiteRowOf(statement));
  return sites;
}

void ForEachMeeting(const Connection& connection,
                    const std::string& select,
                    const BoundingBox& box,
                    const std::function<void(const Statement&)>& visit) {
  const std::string query = select +
                            " site_boxes.west_deg > ?1 AND site_boxes.west_deg <= ?2 AND "
                            "site_boxes.east_deg >= ?3 AND site_boxes.north_deg >= ?4 AND "
                            "site_boxes.south_deg <= ?5";
  for (const auto& [west_above_deg, west_up_to_deg, east_from_deg] : SearchesFor(box)) {
    Statement statement = connection.Prepare(query.c_str());
    statement.Bind(west_above_deg, west_up_to_deg, east_from_deg, box.south_deg, box.north_deg);
    while (statement.Step()) visit(statement);
  }
}

BoxCache<RecallRow>::Rows ListRecallRows(const Connection& connection, const BoundingBox& box) {
  BoxCache<RecallRow>::Rows rows;
  ForEachMeeting(
      connection,
      "SELECT sites.id, flight_id, latitude_deg, longitude_deg, updated_at_us, seen_at_us, "
      "is_landable, altitude_m, altitude_datum, score, aircraft_json, site_numbers.checksum, "
      "confirmed_at_us, map_id, seen_until_us, west_deg, south_deg, east_deg, north_deg, " +
          std::string(kStandingColumns) +
          " FROM site_boxes JOIN site_numbers USING (number) JOIN sites ON sites.id = site_id "
          "WHERE is_recallable = 1 AND superseded_by IS NULL AND",
      box,
      [&rows](const Statement& statement) {
        RecallRow row = RecallRowOf(statement);
        const Standing standing = StandingAt(statement, 19);
        if (standing.IsDoubted()) row.doubt = std::make_shared<const Standing>(standing);
        rows.push_back({BoxOf(statement, 15), std::make_shared<const RecallRow>(std::move(row))});
      });
  return rows;
}

bool DeleteSiteRows(const Connection& writer, const std::string& site_id) {
  writer
      .Prepare(
          "DELETE FROM site_boxes WHERE number IN "
          "(SELECT number FROM site_numbers WHERE site_id = ?1)")
      .Bind(site_id)
      .Run();
  writer.Prepare("DELETE FROM sites WHERE id = ?1").Bind(site_id).Run();
  return writer.NumChanges() > 0;
}

void CheckSiteRows(const Connection& connection) {
  Statement sites = SelectSites(connection, "");
  while (sites.Step()) SiteRowOf(sites);
  Statement recall = connection.Prepare(
      "SELECT sites.id, flight_id, latitude_deg, longitude_deg, updated_at_us, seen_at_us, "
      "is_landable, altitude_m, altitude_datum, score, aircraft_json, site_numbers.checksum, "
      "confirmed_at_us, map_id, seen_until_us, site_boxes.number FROM sites LEFT JOIN "
      "site_numbers ON site_id = sites.id LEFT JOIN site_boxes USING (number)");
  while (recall.Step()) {
    if (!recall.OptionalInt(15)) {
      throw StorageError("read a site", "it has no bounding box", StorageFault::kDamaged);
    }
    RecallRowOf(recall);
  }
}

SiteStamps StampsOf(const Connection& connection) {
  SiteStamps stamps;
  const std::string select =
      "SELECT id, updated_at_us, " + std::string(kStandingColumns) + " FROM sites";
  Statement statement = connection.Prepare(select.c_str());
  while (statement.Step()) {
    Standing standing = StandingAt(statement, 2);
    // No change of its own: a restored site may be checked again.
    standing.is_checked = true;
    stamps.insert({statement.Text(0), {statement.Int(1), std::move(standing)}});
  }
  return stamps;
}

}  // namespace freelsd
