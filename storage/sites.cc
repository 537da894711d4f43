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

bool Storage::DeleteSite(const std::string& site_id) {
  const std::lock_guard lock(state_->write_mutex);
  state_->writer.Prepare("DELETE FROM sites WHERE id = ?1").Bind(site_id).Run();
  return state_->writer.NumChanges() > 0;
}

}  // namespace freelsd
