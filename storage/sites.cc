#include "storage/site_rows.h"
#include "storage/state.h"
#include "storage/storage.h"

namespace freelsd {

void Storage::ReplaceRegions(const std::string& flight_id, const std::vector<RegionRow>& regions) {
  const auto lock = state_->LockForWriting();
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

void Storage::PutSite(const SiteRow& site,
                      std::string_view map_blob,
                      const std::vector<std::string>& supersedes) {
  const auto lock = state_->LockForWriting();
  state_->WriteSites(
      [&](const Connection& connection) { PutSiteRows(connection, site, map_blob, supersedes); });
}

std::optional<SiteRow> Storage::FindSite(const std::string& site_id) const {
  return state_->FindOfSite(
      [&](const Connection& connection) { return FindSiteRow(connection, site_id); });
}

std::vector<SiteRow> Storage::ListSites(const std::optional<std::string>& flight_id,
                                        const std::optional<BoundingBox>& box) const {
  return state_->ReadSites(
      [&](const Connection& connection) { return ListSiteRows(connection, flight_id, box); });
}

std::optional<std::string> Storage::ReadSiteMap(const std::string& site_id) const {
  return state_->FindOfSite(
      [&](const Connection& connection) { return ReadMapBlob(connection, site_id); });
}

RecallBounds Storage::BoundsOfRecallable() const {
  const uint64_t version = state_->sites_version;
  {
    const std::lock_guard lock(state_->bounds_mutex);
    if (state_->bounds_version == version) return state_->bounds;
  }
  RecallBounds bounds = state_->ReadForRecall([](const Connection& connection) {
    RecallBounds read;
    Statement lowest = connection.Prepare(
        "SELECT coalesce(min(altitude_m), 0) FROM site_numbers WHERE is_recallable = 1");
    lowest.Step();
    read.min_altitude_m = lowest.Real(0);
    Statement aircraft = connection.Prepare(
        "SELECT DISTINCT aircraft_json FROM site_numbers WHERE is_recallable = 1 ORDER BY 1");
    while (aircraft.Step()) read.aircraft_jsons.push_back(aircraft.Text(0));
    return read;
  });
  const std::lock_guard lock(state_->bounds_mutex);
  state_->bounds_version = version;
  return state_->bounds = std::move(bounds);
}

SharedRows<RecallRow> Storage::ListRecallable(const BoundingBox& box) const {
  return state_->RowsWithin(state_->recall_rows, box, ListRecallRows);
}

int64_t Storage::CountRecallable() const {
  return state_->ReadForRecall([](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT count(*) FROM site_numbers JOIN sites ON sites.id = site_id "
        "WHERE is_recallable = 1 AND superseded_by IS NULL");
    statement.Step();
    return statement.Int(0);
  });
}

int64_t Storage::CountOverruled(const BoundingBox& box) const {
  return state_->ReadForRecall([&](const Connection& connection) {
    int64_t count = 0;
    for (const BoundingBox& part : PlainBoxes(box)) {
      Statement statement = connection.Prepare(
          // In this order: few sites are superseded, many may lie in the box.
          "SELECT count(*) FROM sites CROSS JOIN site_numbers AS own ON own.site_id = sites.id "
          "CROSS JOIN site_boxes USING (number) "
          "CROSS JOIN site_numbers AS newer ON newer.site_id = superseded_by "
          "WHERE superseded_by IS NOT NULL AND site_boxes.west_deg <= ?3 AND site_boxes.east_deg "
          ">= ?1 AND "
          "site_boxes.south_deg <= ?4 AND site_boxes.north_deg >= ?2 AND "
          "own.is_recallable = 1 AND newer.is_recallable = 0");
      statement.Bind(part.west_deg, part.south_deg, part.east_deg, part.north_deg).Step();
      count += statement.Int(0);
    }
    return count;
  });
}

void Storage::SetSupersededBy(const std::string& site_id,
                              const std::optional<std::string>& newer_id) {
  const auto lock = state_->LockForWriting();
  state_->WriteSites([&](const Connection& connection) {
    connection.Prepare("UPDATE sites SET superseded_by = nullif(?2, '') WHERE id = ?1")
        .Bind(site_id, newer_id.value_or(""))
        .Run();
  });
}

SharedRows<Storage::MapRow> Storage::ListMaps(const BoundingBox& box) const {
  return state_->RowsWithin(state_->map_rows, box, ListMapRows);
}

bool Storage::DeleteSite(const std::string& site_id) {
  const auto lock = state_->LockForWriting();
  bool was_there = false;
  state_->WriteSites([&](const Connection& connection) {
    was_there = DeleteSiteRows(connection, site_id) || was_there;
  });
  return was_there;
}

}  // namespace freelsd
