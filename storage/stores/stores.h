// The stores that both databases share: rows and statements, over StoreAccess. ClaimStore and
// ImageStore are each database's own, and so are the queries below.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "storage/box_cache.h"
#include "storage/database.h"
#include "storage/grouped_writes.h"
#include "storage/storage.h"

namespace freelsd {

class SqlFlightStore final : public FlightStore {
 public:
  explicit SqlFlightStore(StoreAccess& access) : access_(access) {}
  void Insert(const FlightRow& flight) override;
  bool Change(const std::string& flight_id, const FlightChange& change) override;
  std::optional<FlightRow> Find(const std::string& flight_id) const override;
  std::optional<FlightSummary> FindSummary(const std::string& flight_id) const override;
  std::vector<FlightRow> List() const override;
  FlightPage ListPage(size_t limit, std::optional<int64_t> before_number) const override;
  int64_t Count() const override;
  std::vector<std::string> ListWithQueuedFrames() const override;
  bool Delete(const std::string& flight_id) override;
  bool RetireImages(const std::string& flight_id) override;
  void ReplaceRegions(const std::string& flight_id, const std::vector<RegionRow>& regions) override;
  std::vector<RegionRow> ListRegions(const std::string& flight_id) const override;
  int64_t CountRegions(const std::string& flight_id) const override;

 private:
  StoreAccess& access_;
};

// Other writers of the flight's row, frames and telemetry wait until the transaction ends. False if
// there is no such flight.
bool LockFlight(Database& writer, const std::string& flight_id);
// Locks the row. False if there is no such flight.
bool ChangeFlightRow(Database& writer, const std::string& flight_id, const FlightChange& change);
// Also gives up its images. False if there is no such flight.
bool DeleteFlightRow(Writer& writer, const Dialect& dialect, const std::string& flight_id);
// Least allowed arrived_at_us of the next row or frame of a locked flight. It is greater than that
// of every row and frame that the flight has.
int64_t NextArrival(Database& writer, const std::string& flight_id);

class SqlFrameStore final : public FrameStore {
 public:
  explicit SqlFrameStore(StoreAccess& access) : access_(access) {}
  void Insert(const std::string& flight_id,
              const std::vector<FrameRow>& frames,
              const std::optional<JobRow>& job,
              const FlightChange& change) override;
  void Resolve(const std::string& flight_id,
               const std::string& frame_id,
               const std::string& resolved_json,
               const FlightChange& change) override;
  void SetState(const std::string& flight_id,
                const std::string& frame_id,
                FrameState state,
                const std::string& reason) override;
  std::optional<FrameRow> Find(const std::string& flight_id,
                               const std::string& frame_id) const override;
  std::vector<FrameRow> List(const std::string& flight_id) const override;
  void ForEachResolved(
      const std::string& flight_id,
      const std::function<void(const std::string& resolved_json)>& take) const override;
  int64_t CountQueued() const override;
  std::optional<int64_t> OldestQueuedArrival() const override;
  std::optional<FrameRow> Next(const std::string& flight_id, int64_t after_sequence) const override;
  std::vector<FrameRow> LastArrived(const std::string& flight_id,
                                    int max_num_frames) const override;
  std::optional<int64_t> NextQueuedSequence(const std::string& flight_id,
                                            int64_t after_sequence) const override;

 private:
  StoreAccess& access_;
};

class SqlJobStore final : public JobStore {
 public:
  explicit SqlJobStore(StoreAccess& access) : access_(access) {}
  void Insert(const JobRow& job) override;
  bool InsertAlone(const JobRow& job) override;
  void Update(const JobRow& job) override;
  std::optional<JobRow> Find(const std::string& job_id) const override;
  JobPage ListPage(size_t limit,
                   std::optional<int64_t> before_number,
                   size_t max_bytes) const override;
  std::vector<JobRow> ListOf(const std::string& flight_id) const override;
  std::vector<JobRow> ListUnfinished() const override;
  bool Delete(const std::string& job_id) override;

 private:
  StoreAccess& access_;
};

void InsertJobRow(Database& writer, const JobRow& job);

// A sample and its flight.
using Sample = std::pair<std::string, TelemetryRow>;

struct TelemetryQueries {
  // Locks those of the flights that exist and that no other transaction has locked. Their
  // NextArrival, by flight.
  std::map<std::string, int64_t> (*lock_free_flights)(Database& writer,
                                                      const std::vector<std::string>& flight_ids);
  // No two samples of a flight have the same kind and time.
  void (*put)(Database& writer, const std::vector<Sample>& samples);
};

class SqlTelemetryStore final : public TelemetryStore {
 public:
  SqlTelemetryStore(StoreAccess& access, const TelemetryQueries& queries)
      : access_(access), queries_(queries) {}
  bool Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows) override;
  std::vector<TelemetryRow> Recent(const std::string& flight_id,
                                   TelemetryKind kind,
                                   int max_num_rows) const override;
  TelemetryPair Around(const std::string& flight_id,
                       TelemetryKind kind,
                       int64_t timestamp_us) const override;

 private:
  struct Given {
    std::string flight_id;
    const std::vector<TelemetryRow>& rows;
    bool is_stored = false;
  };
  void PutTogether(const std::vector<Given*>& group);
  bool PutAlone(const std::string& flight_id, const std::vector<TelemetryRow>& rows);

  StoreAccess& access_;
  TelemetryQueries queries_;
  GroupedWrites<Given> grouped_;
};

class SqlObstacleStore final : public ObstacleStore {
 public:
  explicit SqlObstacleStore(StoreAccess& access) : access_(access) {}
  void Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) override;
  bool Delete(const std::string& id) override;
  void Merge(const ToldObstacles& told) override;
  std::optional<ObstacleRow> Find(const std::string& id) const override;
  std::vector<ObstacleRow> List() const override;
  uint64_t Version() const override { return access_.ObstaclesVersion(); }

 private:
  StoreAccess& access_;
};

void PutObstacleRow(Database& writer, const ObstacleRow& obstacle);
// True if it existed.
bool DeleteObstacleRow(Database& writer, const std::string& id);
// Throw StorageError kDamaged if a checksum is wrong.
std::optional<ObstacleRow> FindObstacleRow(Database& database, const std::string& id);
std::vector<ObstacleRow> ListObstacleRows(Database& database);

class SqlChangeStore final : public ChangeStore {
 public:
  explicit SqlChangeStore(StoreAccess& access) : access_(access) {}
  std::string FeedId() const override;
  int64_t LastNumber() const override;
  int64_t ForgottenThrough() const override;
  ChangePage List(int64_t after_number,
                  size_t limit,
                  const std::optional<ChangeArea>& area) const override;
  std::optional<ChangeRow> Find(const ChangeKey& key) const override;
  void Repeat(const std::vector<ChangeKey>& keys) override;
  void SetOrigins(const std::vector<ChangeRow>& changes) override;
  void PutRemoval(const ChangeRow& removal) override;
  void ForgetRemoved(int64_t before_us) override;
  std::vector<ChangeRow> ListUnknownAbove(size_t limit) const override;
  void SetKnownAbove(const std::vector<ChangeRow>& changes) override;
  void SetAllUnknownAbove(const std::string& except_origin) override;
  std::optional<FollowState> FindFollowState() const override;
  void PutFollowState(const FollowState& state) override;

 private:
  // Throws StorageError if the database cannot.
  void CheckThatItFollows() const;
  std::string SelectChanges() const;

  StoreAccess& access_;
};

class SqlMapStore final : public MapStore {
 public:
  struct Queries {
    // What else the database keeps of a new map.
    void (*put_area)(Database& writer, const FlightMapRow& map);
    // Images whose files come later.
    void (*put_images_to_come)(Database& writer, const PhotoTiles& photo_tiles);
  };

  SqlMapStore(StoreAccess& access, const Queries& queries) : access_(access), queries_(queries) {}
  std::string NewId(const std::string& flight_id) override;
  void Stage(const FlightMapRow& map, const Tiles& tiles, const PhotoTiles& photo_tiles) override;
  void StageTiles(const std::string& map_id,
                  const Tiles& tiles,
                  const PhotoTiles& photo_tiles) override;
  void Discard(const std::string& map_id) override;
  std::vector<FlightMapRow> ListOf(const std::string& flight_id) const override;
  std::optional<FlightMapRow> Find(const std::string& map_id) const override;
  std::optional<std::string> ReadTile(const std::string& map_id, const TileKey& key) const override;
  std::vector<TileKey> ListTiles(const std::string& map_id) const override;
  std::optional<std::string> ReadTileCopy(const std::string& map_id,
                                          const TileKey& key) const override;
  std::optional<std::string> FindPhotoTile(const std::string& map_id,
                                           const TileKey& key) const override;
  PhotoTiles ListPhotoTiles(const std::string& map_id, int64_t level) const override;
  std::vector<int64_t> CountPhotoTiles(const std::string& map_id) const override;
  void RemovePhotoTiles(const std::string& flight_id) override;
  std::vector<std::string> ListFlightsWithPhotoTiles() const override;

 private:
  void PutTiles(Writer& writer,
                const std::string& map_id,
                const Tiles& tiles,
                const PhotoTiles& photo_tiles);

  StoreAccess& access_;
  Queries queries_;
};

void PutMapRow(Database& writer, const FlightMapRow& map, bool is_in_force);
void PutTileRows(Database& writer, const std::string& map_id, const Tiles& tiles);
void PutMapInForce(Database& writer, const std::string& map_id);
// With its tiles.
void DeleteMapRow(Database& writer, const std::string& map_id);
// Calls `visit` with the maps that `which` selects, from WHERE on. Throws StorageError kDamaged if
// a checksum is wrong.
void ForEachMapRow(Database& database,
                   const std::string& which,
                   const Values& values,
                   const std::function<void(const FlightMapRow&)>& visit);
// Also a map that is not in force.
std::optional<FlightMapRow> FindMapRow(Database& database, const std::string& map_id);

// Writes are within the caller's transaction. Boxes to search must not cross the antimeridian,
// unless it says so.
struct SiteQueries {
  void (*put)(Database& writer, const SiteRow& site);
  // True if it existed.
  bool (*remove)(Database& writer, const std::string& site_id);
  std::optional<SiteRow> (*find)(Database& database, const std::string& site_id);
  std::optional<SiteRow> (*find_whole)(Database& database, const std::string& site_id);
  // By id. The box may cross the antimeridian.
  std::vector<SiteRow> (*list)(Database& database,
                               const std::optional<std::string>& flight_id,
                               const BoundingBox& box);
  // The box may cross the antimeridian.
  std::vector<std::string> (*list_accepted)(Database& database, const BoundingBox& box);
  RecallBounds (*find_bounds)(Database& database);
  BoxCache<RecallRow>::Rows (*list_recallable)(Database& database, const BoundingBox& box);
  BoxCache<MapRow>::Rows (*list_maps)(Database& database, const BoundingBox& box);
  // Of sites that a later map has superseded.
  BoxCache<std::string>::Rows (*list_overruled)(Database& database, const BoundingBox& box);
};

class SqlSiteStore final : public SiteStore {
 public:
  SqlSiteStore(StoreAccess& access, const SiteQueries& queries)
      : access_(access), queries_(queries) {}
  std::unique_ptr<SiteTurn> TakeTurn() override;
  std::optional<SiteRow> Find(const std::string& site_id) const override;
  std::optional<SiteRow> FindWhole(const std::string& site_id) const override;
  std::vector<SiteRow> List(const std::optional<std::string>& flight_id,
                            const std::optional<BoundingBox>& box) const override;
  uint64_t Version() const override { return access_.SitesVersion(); }
  std::vector<std::string> ListDependents(const std::string& site_id) const override;
  std::vector<std::string> ListDependentsOfMap(const std::string& map_id) const override;
  SharedRows<MapRow> ListMaps(const BoundingBox& box) const override;
  std::vector<std::string> ListAccepted(const BoundingBox& box) const override;
  SharedRows<RecallRow> ListRecallable(const BoundingBox& box) const override;
  int64_t CountRecallable() const override;
  bool HasRecallable(const std::string& flight_id) const override;
  RecallBounds BoundsOfRecallable() const override;
  int64_t CountOverruled(const BoundingBox& box) const override;

 private:
  // Through the cache. The box may cross the antimeridian.
  template <typename Cached>
  SharedRows<Cached> Within(BoxCache<Cached>& cache,
                            const BoundingBox& box,
                            typename BoxCache<Cached>::Rows (*list)(Database&,
                                                                    const BoundingBox&)) const {
    return RowsWithin<Cached>(cache, box, Version(), [&](const BoundingBox& wide) {
      return access_.Read([&](Database& database) { return list(database, wide); },
                          Reading::kRecall);
    });
  }

  StoreAccess& access_;
  SiteQueries queries_;
  mutable BoxCache<RecallRow> recall_rows_;
  mutable BoxCache<MapRow> map_rows_;
  mutable BoxCache<std::string> overruled_ids_;
  // Guards bounds_version_ and bounds_.
  mutable std::mutex bounds_mutex_;
  mutable uint64_t bounds_version_ = 0;
  mutable RecallBounds bounds_;
};

// Columns of a site without recall and map_box, and the row that they give.
extern const char* const kSiteColumns;
constexpr int kNumSiteColumns = 18;
SiteRow SiteRowOf(const Row& row);
// Columns of a standing, among those of a site, and what they give.
extern const char* const kStandingColumns;
Standing StandingAt(const Row& row, int first_column);
// Ids without a site are ignored.
void PutStandings(Database& writer, const Standings& standings);
BoundingBox BoxAt(const Row& row, int first_column);

}  // namespace freelsd
