#include <algorithm>
#include <mutex>

#include "storage/sqlite/flight_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/site_queries.h"
#include "storage/sqlite/site_standings.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

std::vector<std::string> IdsOf(Statement& statement) {
  std::vector<std::string> ids;
  while (statement.Step()) ids.push_back(statement.Text(0));
  return ids;
}

void SetSitesUnknownAbove(const Connection& connection, const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    connection.Prepare("UPDATE changes SET is_known_above = 0 WHERE subject = 0 AND id = ?1")
        .Bind(id)
        .Run();
  }
}

class SqliteSiteTurn final : public SiteTurn {
 public:
  explicit SqliteSiteTurn(StorageState& state) : state_(state), turn_(state.turns_mutex) {}

  void PutEvaluation(const EvaluationRows& rows, const Standings& others) override;
  bool Delete(const std::string& site_id, const Standings& others) override;
  void SetStandings(const Standings& standings) override {
    if (standings.empty()) return turn_.unlock();
    const auto lock = state_.LockForWriting();
    state_.WriteSites([&](const Connection& connection) { PutStandings(connection, standings); });
    turn_.unlock();
  }

 private:
  StorageState& state_;
  std::unique_lock<std::mutex> turn_;
};

void SqliteSiteTurn::PutEvaluation(const EvaluationRows& rows, const Standings& others) {
  const auto lock = state_.LockForWriting();
  std::vector<std::string> files = OwnPhotoFiles(state_.writer, rows.forgotten_maps);
  const auto write = [&](const Connection& connection) {
    for (const std::string& id : rows.forgotten_sites) DeleteSiteRows(connection, id);
    for (const std::string& id : rows.forgotten_maps) DeleteMapRow(connection, id);
    for (const std::string& id : rows.new_maps) PutMapInForce(connection, id);
    for (const SiteRow& site : rows.sites) PutSiteRows(connection, site);
    PutStandings(connection, others);
    SetSitesUnknownAbove(connection, rows.sites_unknown_above);
    if (!rows.deleted_flight) return;
    const auto images = DeleteFlightRow(connection, *rows.deleted_flight);
    if (images) files.insert(files.end(), images->begin(), images->end());
  };
  state_.WriteSites(write, rows.is_from_above ? Teller::kAbove : Teller::kThisServer);
  turn_.unlock();
  for (const std::string& sha256 : files) state_.images.Remove(sha256);
}

bool SqliteSiteTurn::Delete(const std::string& site_id, const Standings& others) {
  const auto lock = state_.LockForWriting();
  bool was_there = false;
  state_.WriteSites([&](const Connection& connection) {
    if (!DeleteSiteRows(connection, site_id)) return;
    was_there = true;
    PutStandings(connection, others);
  });
  turn_.unlock();
  return was_there;
}

// Of sites that a later map has superseded.
BoxCache<std::string>::Rows ListOverruledIds(const Connection& connection,
                                             const BoundingBox& within) {
  BoxCache<std::string>::Rows rows;
  ForEachMeeting(
      connection,
      // CROSS JOIN fixes the order: few sites are superseded, but many may lie in the box.
      "SELECT sites.id, west_deg, south_deg, east_deg, north_deg FROM sites "
      "CROSS JOIN site_numbers ON site_id = sites.id CROSS JOIN site_boxes USING (number) "
      "WHERE superseded_by IS NOT NULL AND is_recallable = 1 AND",
      within,
      [&rows](const Statement& statement) {
        const BoundingBox box =
            Rolled({statement.Real(1), statement.Real(2), statement.Real(3), statement.Real(4)});
        rows.push_back({box, std::make_shared<const std::string>(statement.Text(0))});
      });
  return rows;
}

}  // namespace

uint64_t SqliteSiteStore::Version() const { return state_.sites_version; }

std::unique_ptr<SiteTurn> SqliteSiteStore::TakeTurn() {
  return std::make_unique<SqliteSiteTurn>(state_);
}

std::optional<SiteRow> SqliteSiteStore::Find(const std::string& site_id) const {
  return state_.FindOfSite(
      [&](const Connection& connection) { return FindSiteRow(connection, site_id); });
}

std::optional<SiteRow> SqliteSiteStore::FindWhole(const std::string& site_id) const {
  return state_.FindOfSite(
      [&](const Connection& connection) { return FindWholeSiteRow(connection, site_id); });
}

std::vector<SiteRow> SqliteSiteStore::List(const std::optional<std::string>& flight_id,
                                           const std::optional<BoundingBox>& box) const {
  return state_.ReadSites(
      [&](const Connection& connection) { return ListSiteRows(connection, flight_id, box); });
}

RecallBounds SqliteSiteStore::BoundsOfRecallable() const {
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
    // One search of an index for each aircraft: many sites are of the same.
    Statement aircraft = connection.Prepare(
        "WITH RECURSIVE found (json) AS (SELECT min(aircraft_json) FROM site_numbers "
        "WHERE is_recallable = 1 UNION ALL SELECT (SELECT min(aircraft_json) FROM site_numbers "
        "WHERE is_recallable = 1 AND aircraft_json > json) FROM found WHERE json IS NOT NULL) "
        "SELECT json FROM found WHERE json IS NOT NULL");
    while (aircraft.Step()) read.aircraft_jsons.push_back(aircraft.Text(0));
    return read;
  });
  const std::lock_guard lock(state_.bounds_mutex);
  state_.bounds_version = version;
  return state_.bounds = std::move(bounds);
}

SharedRows<RecallRow> SqliteSiteStore::ListRecallable(const BoundingBox& box) const {
  return state_.RowsWithin(state_.recall_rows, box, ListRecallRows);
}

int64_t SqliteSiteStore::CountRecallable() const {
  return state_.ReadForRecall([](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT count(*) FROM site_numbers JOIN sites ON sites.id = site_id "
        "WHERE is_recallable = 1 AND superseded_by IS NULL");
    statement.Step();
    return statement.Int(0);
  });
}

bool SqliteSiteStore::HasRecallable(const std::string& flight_id) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT 1 FROM sites JOIN site_numbers ON site_id = sites.id "
        "WHERE flight_id = ?1 AND is_recallable = 1 LIMIT 1");
    return statement.Bind(flight_id).Step();
  });
}

int64_t SqliteSiteStore::CountOverruled(const BoundingBox& box) const {
  return static_cast<int64_t>(
      state_.RowsWithin(state_.overruled_ids, box, ListOverruledIds).size());
}

std::vector<std::string> SqliteSiteStore::ListDependents(const std::string& site_id) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement =
        connection.Prepare("SELECT id FROM sites WHERE superseded_by = ?1 ORDER BY id");
    return IdsOf(statement.Bind(site_id));
  });
}

std::vector<std::string> SqliteSiteStore::ListDependentsOfMap(const std::string& map_id) const {
  return state_.ReadSites([&](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT id FROM sites WHERE superseded_by_map = ?1 UNION SELECT id FROM sites "
        "WHERE confirmed_at_us = (SELECT seen_at_us FROM maps WHERE id = ?1) ORDER BY id");
    return IdsOf(statement.Bind(map_id));
  });
}

std::vector<std::string> SqliteSiteStore::ListUnchecked() const {
  return state_.ReadSites([](const Connection& connection) {
    Statement statement = connection.Prepare(
        "SELECT sites.id FROM sites JOIN site_numbers ON site_id = sites.id "
        "WHERE is_checked = 0 AND is_recallable = 1 ORDER BY sites.id");
    return IdsOf(statement);
  });
}

SharedRows<MapRow> SqliteSiteStore::ListMaps(const BoundingBox& box) const {
  return state_.RowsWithin(state_.map_rows, box, ListMapRows);
}

std::vector<std::string> SqliteSiteStore::ListAccepted(const BoundingBox& box) const {
  return state_.ReadSites([&](const Connection& connection) {
    std::vector<std::string> ids;
    ForEachMeeting(connection,
                   "SELECT site_id FROM site_boxes JOIN site_numbers USING (number) "
                   "JOIN sites ON sites.id = site_id "
                   "WHERE (is_recallable = 1 OR approach_json <> '') AND",
                   box,
                   [&ids](const Statement& statement) { ids.push_back(statement.Text(0)); });
    std::sort(ids.begin(), ids.end());
    return ids;
  });
}

}  // namespace freelsd
