#include <algorithm>
#include <mutex>
#include <optional>

#include "storage/boxes.h"
#include "storage/postgres/area_rows.h"
#include "storage/postgres/flight_rows.h"
#include "storage/postgres/images.h"
#include "storage/postgres/site_rows.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr BoundingBox kWholeEarth{-180.0, -90.0, 180.0, 90.0};

bool DeleteSite(PostgresConnection& writer, const std::string& site_id) {
  return writer.Run("DELETE FROM sites WHERE id = $1", site_id).NumChanges() > 0;
}

std::vector<std::string> PhotosOf(PostgresConnection& writer,
                                  const std::vector<std::string>& map_ids) {
  std::vector<std::string> images;
  for (const std::string& id : map_ids) {
    const std::vector<std::string> some =
        writer.Run("SELECT DISTINCT sha256 FROM photo_tiles WHERE map_id = $1", id).Texts();
    images.insert(images.end(), some.begin(), some.end());
  }
  std::sort(images.begin(), images.end());
  images.erase(std::unique(images.begin(), images.end()), images.end());
  return images;
}

// Holds the row of the version of sites, which all who change sites need.
class PostgresSiteTurn final : public SiteTurn {
 public:
  explicit PostgresSiteTurn(PostgresState& state) : state_(state), lock_(state.turns_mutex) {
    writer_.emplace(state_);
    StepSites(**writer_);
  }

  void PutEvaluation(const EvaluationRows& rows, const Standings& others) override;
  bool Delete(const std::string& site_id, const Standings& others) override {
    const bool was_there = DeleteSite(**writer_, site_id);
    if (was_there) PutSiteStandings(**writer_, others);
    End();
    return was_there;
  }
  void SetStandings(const Standings& standings) override {
    PutSiteStandings(**writer_, standings);
    End();
  }

 private:
  void End() {
    writer_->Commit();
    writer_.reset();
    lock_.unlock();
  }

  PostgresState& state_;
  // One connection of each process waits for the row.
  std::unique_lock<std::mutex> lock_;
  std::optional<PostgresWrite> writer_;
};

void PostgresSiteTurn::PutEvaluation(const EvaluationRows& rows, const Standings& others) {
  PostgresWrite& writer = *writer_;
  std::vector<std::string> images = PhotosOf(*writer, rows.forgotten_maps);
  for (const std::string& id : rows.forgotten_sites) DeleteSite(*writer, id);
  for (const std::string& id : rows.forgotten_maps) {
    writer->Run("DELETE FROM maps WHERE id = $1", id);
  }
  for (const std::string& id : rows.new_maps) {
    writer->Run("UPDATE maps SET is_in_force = true WHERE id = $1", id);
  }
  for (const SiteRow& site : rows.sites) PutSite(*writer, site);
  PutSiteStandings(*writer, others);
  if (rows.deleted_flight) {
    const auto of_frames = DeleteFlightRow(*writer, *rows.deleted_flight);
    if (of_frames) images.insert(images.end(), of_frames->begin(), of_frames->end());
  }
  End();
  RemoveUnusedImages(state_, images);
}

std::vector<std::string> ReadIds(PostgresState& state,
                                 const std::string& sql,
                                 const std::string& value) {
  return state.Read(
      [&](PostgresConnection& connection) { return connection.Run(sql, value).Texts(); });
}

}  // namespace

uint64_t PostgresSiteStore::Version() const { return state_.VersionOf("sites"); }

std::unique_ptr<SiteTurn> PostgresSiteStore::TakeTurn() {
  return std::make_unique<PostgresSiteTurn>(state_);
}

std::optional<SiteRow> PostgresSiteStore::Find(const std::string& site_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<SiteRow> {
    const PostgresRows rows = connection.Run(
        std::string("SELECT ") + kSiteColumns + " FROM sites WHERE id = $1", site_id);
    if (rows.empty()) return std::nullopt;
    return SiteRowOf(rows[0]);
  });
}

std::optional<SiteRow> PostgresSiteStore::FindWhole(const std::string& site_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<SiteRow> {
    const PostgresRows rows = connection.Run(
        std::string("SELECT ") + kSiteColumns + ", " + kRecallColumns + " FROM sites WHERE id = $1",
        site_id);
    if (rows.empty()) return std::nullopt;
    return WholeSiteRowOf(rows[0]);
  });
}

std::vector<SiteRow> PostgresSiteStore::List(const std::optional<std::string>& flight_id,
                                             const std::optional<BoundingBox>& box) const {
  const BoundingBox wanted = box.value_or(kWholeEarth);
  // The index finds a few more than the box holds; the degrees decide.
  const BoundingBox unrolled = Unrolled(wanted);
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(std::string("SELECT ") + kSiteColumns +
                 " FROM sites WHERE (NOT $1 OR flight_id = $2) "
                 "AND latitude_deg BETWEEN $3 AND $5 AND CASE WHEN $4 <= $6 "
                 "THEN longitude_deg BETWEEN $4 AND $6 "
                 "ELSE longitude_deg >= $4 OR longitude_deg <= $6 END "
                 "AND (touchdown && ST_MakeEnvelope($4, $3, $7, $5, 4326) "
                 "OR touchdown && ST_MakeEnvelope($4 - 360, $3, $7 - 360, $5, 4326)) ORDER BY id",
             flight_id.has_value(),
             flight_id.value_or(""),
             wanted.south_deg,
             wanted.west_deg,
             wanted.north_deg,
             wanted.east_deg,
             unrolled.east_deg)
        .Each(SiteRowOf);
  });
}

std::vector<std::string> PostgresSiteStore::ListDependents(const std::string& site_id) const {
  return ReadIds(state_, "SELECT id FROM sites WHERE superseded_by = $1 ORDER BY id", site_id);
}

std::vector<std::string> PostgresSiteStore::ListDependentsOfMap(const std::string& map_id) const {
  return ReadIds(state_,
                 "SELECT id FROM sites WHERE superseded_by_map = $1 UNION SELECT id FROM sites "
                 "WHERE confirmed_at_us = (SELECT seen_at_us FROM maps WHERE id = $1) ORDER BY id",
                 map_id);
}

std::vector<std::string> PostgresSiteStore::ListUnchecked() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT id FROM sites WHERE is_recallable AND NOT is_checked ORDER BY id")
        .Texts();
  });
}

SharedRows<MapRow> PostgresSiteStore::ListMaps(const BoundingBox& box) const {
  return RowsWithin<MapRow>(state_.map_rows, box, Version(), [&](const BoundingBox& wide) {
    return state_.Read(
        [&](PostgresConnection& connection) { return SelectMapRows(connection, wide); });
  });
}

std::vector<std::string> PostgresSiteStore::ListAccepted(const BoundingBox& box) const {
  return state_.Read([&](PostgresConnection& connection) {
    std::vector<std::string> ids =
        SelectSitesMeeting(connection,
                           "SELECT id FROM sites WHERE (is_recallable OR approach_json <> '') "
                           "AND id IN",
                           box)
            .Texts();
    std::sort(ids.begin(), ids.end());
    return ids;
  });
}

SharedRows<RecallRow> PostgresSiteStore::ListRecallable(const BoundingBox& box) const {
  return RowsWithin<RecallRow>(state_.recall_rows, box, Version(), [&](const BoundingBox& wide) {
    return state_.Read(
        [&](PostgresConnection& connection) { return SelectRecallRows(connection, wide); });
  });
}

int64_t PostgresSiteStore::CountRecallable() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection
        .Run("SELECT count(*) FROM sites WHERE is_recallable AND superseded_by IS NULL")[0]
        .Int(0);
  });
}

bool PostgresSiteStore::HasRecallable(const std::string& flight_id) const {
  return !ReadIds(state_,
                  "SELECT id FROM sites WHERE flight_id = $1 AND is_recallable LIMIT 1",
                  flight_id)
              .empty();
}

RecallBounds PostgresSiteStore::BoundsOfRecallable() const {
  const uint64_t version = Version();
  {
    const std::lock_guard lock(state_.bounds_mutex);
    if (state_.bounds_version == version) return state_.bounds;
  }
  RecallBounds bounds = state_.Read([](PostgresConnection& connection) {
    RecallBounds read;
    read.min_altitude_m =
        connection.Run("SELECT coalesce(min(altitude_m), 0) FROM sites WHERE is_recallable")[0]
            .Real(0);
    // One search of an index for each aircraft: many sites are of the same.
    read.aircraft_jsons =
        connection
            .Run(
                "WITH RECURSIVE found AS ((SELECT aircraft_json COLLATE \"C\" AS json FROM sites "
                "WHERE is_recallable ORDER BY 1 LIMIT 1) UNION ALL SELECT (SELECT aircraft_json "
                "COLLATE \"C\" FROM sites WHERE is_recallable AND aircraft_json COLLATE \"C\" > "
                "json ORDER BY 1 LIMIT 1) FROM found WHERE json IS NOT NULL) "
                "SELECT json FROM found WHERE json IS NOT NULL")
            .Texts();
    return read;
  });
  const std::lock_guard lock(state_.bounds_mutex);
  state_.bounds_version = version;
  return state_.bounds = std::move(bounds);
}

int64_t PostgresSiteStore::CountOverruled(const BoundingBox& box) const {
  const auto ids =
      RowsWithin<std::string>(state_.overruled_ids, box, Version(), [&](const BoundingBox& wide) {
        return state_.Read(
            [&](PostgresConnection& connection) { return SelectOverruledIds(connection, wide); });
      });
  return static_cast<int64_t>(ids.size());
}

}  // namespace freelsd
