#include <mutex>

#include "storage/state.h"
#include "storage/storage.h"

namespace freelsd {
namespace {

constexpr BoundingBox kWholeEarth{-180.0, -90.0, 180.0, 90.0};

SiteRow RowOf(const Statement& statement) {
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
  return site;
}

void PutSiteRow(const Connection& writer, const SiteRow& site) {
  writer
      .Prepare(
          "INSERT INTO sites VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) ON CONFLICT (id) DO "
          "UPDATE "
          "SET latitude_deg = ?4, longitude_deg = ?5, feature_json = ?6, approach_json = ?7, "
          "replan_json = ?8, updated_at_us = ?9")
      .Bind(site.id,
            site.flight_id,
            site.region_id,
            site.latitude_deg,
            site.longitude_deg,
            site.feature_json,
            site.approach_json,
            site.replan_json,
            site.updated_at_us)
      .Run();
}

int64_t NumberOf(const Connection& writer, const std::string& site_id) {
  Statement statement = writer.Prepare("SELECT number FROM site_numbers WHERE site_id = ?1");
  statement.Bind(site_id).Step();
  return statement.Int(0);
}

void PutRecall(const Connection& writer, const SiteRow& site) {
  const RecallData data = site.recall.value_or(RecallData{});
  writer
      .Prepare(
          "INSERT INTO site_numbers (site_id, is_recallable, is_landable, altitude_m, "
          "altitude_datum, score, aircraft_json) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) "
          "ON CONFLICT (site_id) DO UPDATE SET is_recallable = ?2, is_landable = ?3, "
          "altitude_m = ?4, altitude_datum = ?5, score = ?6, aircraft_json = ?7")
      .Bind(site.id,
            static_cast<int>(site.recall.has_value()),
            static_cast<int>(data.is_landable),
            data.altitude_m,
            data.altitude_datum,
            data.score,
            data.aircraft_json)
      .Run();
  const BoundingBox touchdown{
      site.longitude_deg, site.latitude_deg, site.longitude_deg, site.latitude_deg};
  const BoundingBox box = site.map_box.value_or(touchdown);
  writer.Prepare("INSERT OR REPLACE INTO site_boxes VALUES (?1, ?2, ?3, ?4, ?5)")
      .Bind(NumberOf(writer, site.id), box.west_deg, box.east_deg, box.south_deg, box.north_deg)
      .Run();
}

// One box, or the two halves of one that crosses the antimeridian.
std::vector<BoundingBox> PlainBoxes(const BoundingBox& box) {
  if (box.west_deg <= box.east_deg) return {box};
  return {{box.west_deg, box.south_deg, 180.0, box.north_deg},
          {-180.0, box.south_deg, box.east_deg, box.north_deg}};
}

RecallRow RecallRowOf(const Statement& statement) {
  RecallRow row;
  row.site_id = statement.Text(0);
  row.flight_id = statement.Text(1);
  row.latitude_deg = statement.Real(2);
  row.longitude_deg = statement.Real(3);
  row.updated_at_us = statement.Int(4);
  row.data = {statement.Int(5) != 0,
              statement.Real(6),
              statement.Text(7),
              statement.Real(8),
              statement.Text(9)};
  return row;
}

}  // namespace

void Storage::ReplaceRegions(const std::string& flight_id, const std::vector<RegionRow>& regions) {
  const std::lock_guard lock(state_->write_mutex);
  Transaction transaction(state_->writer);
  state_->writer.Prepare("DELETE FROM regions WHERE flight_id = ?1").Bind(flight_id).Run();
  int64_t rank = 0;
  for (const RegionRow& region : regions) {
    state_->writer.Prepare("INSERT INTO regions VALUES (?1, ?2, ?3, ?4, ?5)")
        .Bind(flight_id, region.id, rank++, region.feature_json, region.history_json)
        .Run();
  }
  transaction.Commit();
}

std::vector<Storage::RegionRow> Storage::ListRegions(const std::string& flight_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare(
      "SELECT id, feature_json, history_json FROM regions WHERE flight_id = ?1 ORDER BY rank");
  statement.Bind(flight_id);
  std::vector<RegionRow> regions;
  while (statement.Step()) {
    regions.push_back({statement.Int(0), statement.Text(1), statement.Text(2)});
  }
  return regions;
}

int64_t Storage::CountRegions(const std::string& flight_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare("SELECT count(*) FROM regions WHERE flight_id = ?1");
  statement.Bind(flight_id).Step();
  return statement.Int(0);
}

int64_t Storage::CountSites(const std::string& flight_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare("SELECT count(*) FROM sites WHERE flight_id = ?1");
  statement.Bind(flight_id).Step();
  return statement.Int(0);
}

void Storage::PutSite(const SiteRow& site, std::string_view map_blob) {
  const std::lock_guard lock(state_->write_mutex);
  Transaction transaction(state_->writer);
  PutSiteRow(state_->writer, site);
  PutRecall(state_->writer, site);
  if (map_blob.empty()) {
    state_->writer.Prepare("DELETE FROM site_maps WHERE site_id = ?1").Bind(site.id).Run();
  } else {
    state_->writer.Prepare("INSERT OR REPLACE INTO site_maps VALUES (?1, ?2)")
        .Bind(site.id, Blob{map_blob})
        .Run();
  }
  transaction.Commit();
}

std::optional<SiteRow> Storage::FindSite(const std::string& site_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare(
      "SELECT id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json, "
      "replan_json, updated_at_us FROM sites WHERE id = ?1");
  if (!statement.Bind(site_id).Step()) return std::nullopt;
  return RowOf(statement);
}

std::vector<SiteRow> Storage::ListSites(const std::optional<std::string>& flight_id,
                                        const std::optional<BoundingBox>& box) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare(
      "SELECT id, flight_id, region_id, latitude_deg, longitude_deg, feature_json, approach_json, "
      "replan_json, updated_at_us FROM sites WHERE (?1 = 0 OR flight_id = ?2) AND "
      "latitude_deg BETWEEN ?3 AND ?5 AND ("
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
  while (statement.Step()) sites.push_back(RowOf(statement));
  return sites;
}

std::optional<std::string> Storage::ReadSiteMap(const std::string& site_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare("SELECT map FROM site_maps WHERE site_id = ?1");
  if (!statement.Bind(site_id).Step()) return std::nullopt;
  return statement.Text(0);
}

std::vector<RecallRow> Storage::ListRecallable(const BoundingBox& box) const {
  const Reader reader(state_->readers);
  std::vector<RecallRow> rows;
  for (const BoundingBox& part : PlainBoxes(box)) {
    Statement statement = reader->Prepare(
        "SELECT sites.id, flight_id, latitude_deg, longitude_deg, updated_at_us, is_landable, "
        "altitude_m, altitude_datum, score, aircraft_json FROM site_boxes "
        "JOIN site_numbers USING (number) JOIN sites ON sites.id = site_id "
        "WHERE site_boxes.west_deg <= ?3 AND site_boxes.east_deg >= ?1 AND "
        "site_boxes.south_deg <= ?4 AND site_boxes.north_deg >= ?2 AND is_recallable = 1");
    statement.Bind(part.west_deg, part.south_deg, part.east_deg, part.north_deg);
    while (statement.Step()) rows.push_back(RecallRowOf(statement));
  }
  return rows;
}

std::vector<Storage::MapRow> Storage::ListMaps(const BoundingBox& box) const {
  const Reader reader(state_->readers);
  std::vector<MapRow> rows;
  for (const BoundingBox& part : PlainBoxes(box)) {
    Statement statement = reader->Prepare(
        "SELECT sites.id, updated_at_us, altitude_datum FROM site_boxes "
        "JOIN site_numbers USING (number) JOIN sites ON sites.id = site_id "
        "WHERE site_boxes.west_deg <= ?3 AND site_boxes.east_deg >= ?1 AND "
        "site_boxes.south_deg <= ?4 AND site_boxes.north_deg >= ?2");
    statement.Bind(part.west_deg, part.south_deg, part.east_deg, part.north_deg);
    while (statement.Step())
      rows.push_back({statement.Text(0), statement.Int(1), statement.Text(2)});
  }
  return rows;
}

bool Storage::DeleteSite(const std::string& site_id) {
  const std::lock_guard lock(state_->write_mutex);
  state_->writer.Prepare("DELETE FROM sites WHERE id = ?1").Bind(site_id).Run();
  return state_->writer.NumChanges() > 0;
}

}  // namespace freelsd
