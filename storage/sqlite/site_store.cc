#include "storage/site_store.h"

#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/state.h"

namespace freelsd {

void SiteStore::Put(const SiteRow& site,
                    std::string_view map_blob,
                    const std::vector<std::string>& supersedes) {
  const auto lock = state_.LockForWriting();
  state_.WriteSites(
      [&](const Connection& connection) { PutSiteRows(connection, site, map_blob, supersedes); });
}

std::optional<SiteRow> SiteStore::Find(const std::string& site_id) const {
  return state_.FindOfSite(
      [&](const Connection& connection) { return FindSiteRow(connection, site_id); });
}

std::vector<SiteRow> SiteStore::List(const std::optional<std::string>& flight_id,
                                     const std::optional<BoundingBox>& box) const {
  return state_.ReadSites(
      [&](const Connection& connection) { return ListSiteRows(connection, flight_id, box); });
}

std::optional<std::string> SiteStore::ReadMap(const std::string& site_id) const {
  return state_.FindOfSite(
      [&](const Connection& connection) { return ReadMapBlob(connection, site_id); });
}

RecallBounds SiteStore::BoundsOfRecallable() const {
  const uint64_t version = state_.sites_version;
  {
    const std::lock_guard lock(state_.bounds_mutex);
    if (state_.bounds_version == version) return state_.bounds;
  }
  RecallBounds bounds = state_.ReadForRecall([](const Connection& connection) {
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
  const std::lock_guard lock(state_.bounds_mutex);
  state_.bounds_version = version;
  return state_.bounds = std::move(bounds);
}

SharedRows<RecallRow> SiteStore::ListRecallable(const BoundingBox& box) const {
  return state_.RowsWithin(state_.recall_rows, box, ListRecallRows);
}

int64_t SiteStore::CountRecallable() const {
  return state_.ReadForRecall([](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT count(*) FROM site_numbers JOIN sites ON sites.id = site_id "
        "WHERE is_recallable = 1 AND superseded_by IS NULL");
    statement.Step();
    return statement.Int(0);
  });
}

int64_t SiteStore::CountOverruled(const BoundingBox& box) const {
  return state_.ReadForRecall([&](const Connection& connection) {
    int64_t count = 0;
    for (const BoundingBox& part : PlainBoxes(box)) {
      Statement statement = connection.Prepare(
          // CROSS JOIN fixes the order: few sites are superseded, but many may lie in the box.
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

void SiteStore::SetSupersededBy(const std::string& site_id,
                                const std::optional<std::string>& newer_id) {
  const auto lock = state_.LockForWriting();
  state_.WriteSites([&](const Connection& connection) {
    connection.Prepare("UPDATE sites SET superseded_by = nullif(?2, '') WHERE id = ?1")
        .Bind(site_id, newer_id.value_or(""))
        .Run();
  });
}

SharedRows<MapRow> SiteStore::ListMaps(const BoundingBox& box) const {
  return state_.RowsWithin(state_.map_rows, box, ListMapRows);
}

bool SiteStore::Delete(const std::string& site_id) {
  const auto lock = state_.LockForWriting();
  bool was_there = false;
  state_.WriteSites([&](const Connection& connection) {
    was_there = DeleteSiteRows(connection, site_id) || was_there;
  });
  return was_there;
}

}  // namespace freelsd
