#include "storage/postgres/site_rows.h"

#include <algorithm>
#include <memory>

#include "storage/postgres/area_rows.h"

namespace freelsd {
namespace {

BoundingBox BoxAt(const PostgresRow& row, int first_column) {
  return {row.Real(first_column),
          row.Real(first_column + 1),
          row.Real(first_column + 2),
          row.Real(first_column + 3)};
}

Standing StandingOf(const PostgresRow& row, int first_column) {
  Standing standing;
  if (std::string id = row.Text(first_column); !id.empty()) standing.superseded_by = std::move(id);
  standing.superseded_at_us = row.OptionalInt(first_column + 1).value_or(0);
  standing.superseded_reason = row.Text(first_column + 2);
  standing.superseded_detail = row.Text(first_column + 3);
  standing.confirmed_at_us = row.OptionalInt(first_column + 4);
  standing.is_checked = row.Bool(first_column + 5);
  standing.superseded_by_map = row.Text(first_column + 6);
  return standing;
}

Boxed<RecallRow> BoxedRecallRow(const PostgresRow& row) {
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
  const Standing standing = StandingOf(row, 18);
  if (standing.IsDoubted()) site.doubt = std::make_shared<const Standing>(standing);
  return {BoxAt(row, 13), std::make_shared<const RecallRow>(std::move(site))};
}

Boxed<MapRow> BoxedMapRow(const PostgresRow& row) {
  return {BoxAt(row, 5),
          std::make_shared<const MapRow>(
              MapRow{row.Text(0), row.Text(1), row.Text(2), row.Int(3), row.OptionalInt(4)})};
}

}  // namespace

const char* const kSiteColumns =
    "id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json, "
    "replan_json, updated_at_us, seen_at_us, map_id, superseded_by, superseded_at_us, "
    "superseded_reason, superseded_detail, confirmed_at_us, is_checked, superseded_by_map, "
    "seen_until_us";

SiteRow SiteRowOf(const PostgresRow& row) {
  SiteRow site;
  site.id = row.Text(0);
  site.flight_id = row.Text(1);
  site.region_id = row.Int(2);
  site.latitude_deg = row.Real(3);
  site.longitude_deg = row.Real(4);
  site.feature_json = row.Text(5);
  site.approach_json = row.Text(6);
  site.replan_json = row.Text(7);
  site.updated_at_us = row.Int(8);
  site.seen_at_us = row.Int(9);
  site.map_id = row.Text(10);
  static_cast<Standing&>(site) = StandingOf(row, 11);
  site.seen_until_us = row.OptionalInt(18);
  return site;
}

const char* const kRecallColumns =
    "is_recallable, is_landable, altitude_m, altitude_datum, score, aircraft_json, west_deg, "
    "south_deg, east_deg, north_deg";

SiteRow WholeSiteRowOf(const PostgresRow& row) {
  constexpr int kFirst = 19;
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

void PutSite(PostgresConnection& writer, const SiteRow& site) {
  RecallData data = site.recall.value_or(RecallData{});
  if (!site.recall) data.altitude_datum = site.map_datum;
  const BoundingBox touchdown{
      site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg};
  const BoundingBox box = site.map_box.value_or(touchdown);
  writer.Run(
      "INSERT INTO sites (id, flight_id, region_id, map_id, latitude_deg, longitude_deg, "
      "feature_json, approach_json, replan_json, updated_at_us, seen_at_us, is_recallable, "
      "is_landable, altitude_m, altitude_datum, score, aircraft_json, west_deg, south_deg, "
      "east_deg, north_deg, seen_until_us) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, "
      "$12, $13, $14, $15, $16, $17, $18, $19, $20, $21, nullif($22, 0)) ON CONFLICT (id) DO "
      "UPDATE SET flight_id = $2, "
      "region_id = $3, map_id = $4, latitude_deg = $5, longitude_deg = $6, feature_json = $7, "
      "approach_json = $8, replan_json = $9, updated_at_us = $10, seen_at_us = $11, "
      "is_recallable = $12, is_landable = $13, altitude_m = $14, altitude_datum = $15, "
      "score = $16, aircraft_json = $17, west_deg = $18, south_deg = $19, east_deg = $20, "
      "north_deg = $21, seen_until_us = nullif($22, 0)",
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
      site.seen_until_us.value_or(0));
  PutSiteArea(writer, site.id, box);
  PutSiteStandings(writer, {{site.id, site}});
}

void PutSiteStandings(PostgresConnection& writer, const Standings& standings) {
  for (const auto& [id, standing] : standings) {
    writer.Run(
        "UPDATE sites SET superseded_by = nullif($2, ''), superseded_at_us = nullif($3, 0), "
        "superseded_reason = $4, superseded_detail = $5, confirmed_at_us = nullif($6, 0), "
        "is_checked = $7, superseded_by_map = $8 WHERE id = $1",
        id,
        standing.superseded_by.value_or(""),
        standing.superseded_at_us,
        standing.superseded_reason,
        standing.superseded_detail,
        standing.confirmed_at_us.value_or(0),
        standing.is_checked,
        standing.superseded_by_map);
  }
}

BoxCache<RecallRow>::Rows SelectRecallRows(PostgresConnection& connection, const BoundingBox& box) {
  return SelectSitesMeeting(
             connection,
             "SELECT id, flight_id, map_id, latitude_deg, longitude_deg, updated_at_us, "
             "seen_at_us, confirmed_at_us, is_landable, altitude_m, altitude_datum, score, "
             "aircraft_json, west_deg, south_deg, east_deg, north_deg, seen_until_us, "
             "superseded_by, superseded_at_us, superseded_reason, superseded_detail, "
             "confirmed_at_us, is_checked, superseded_by_map FROM sites "
             "WHERE is_recallable AND superseded_by IS NULL AND id IN",
             box)
      .Each(BoxedRecallRow);
}

BoxCache<std::string>::Rows SelectOverruledIds(PostgresConnection& connection,
                                               const BoundingBox& box) {
  return SelectSitesMeeting(connection,
                            "SELECT id, west_deg, south_deg, east_deg, north_deg FROM sites "
                            "WHERE superseded_by IS NOT NULL AND is_recallable AND id IN",
                            box)
      .Each([](const PostgresRow& row) {
        return Boxed<std::string>{BoxAt(row, 1), std::make_shared<const std::string>(row.Text(0))};
      });
}

BoxCache<MapRow>::Rows SelectMapRows(PostgresConnection& connection, const BoundingBox& box) {
  return SelectMapsMeeting(connection,
                           "SELECT id, flight_id, altitude_datum, seen_at_us, seen_until_us, "
                           "west_deg, south_deg, east_deg, north_deg FROM maps "
                           "WHERE is_in_force AND id IN",
                           box)
      .Each(BoxedMapRow);
}

}  // namespace freelsd
