// The stores in PostgreSQL: each reads and writes through the state that all share.
#pragma once

#include "storage/grouped_writes.h"
#include "storage/storage.h"

namespace freelsd {

struct PostgresState;

class PostgresFlightStore final : public FlightStore {
 public:
  explicit PostgresFlightStore(PostgresState& state) : state_(state) {}
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
  PostgresState& state_;
};

class PostgresFrameStore final : public FrameStore {
 public:
  explicit PostgresFrameStore(PostgresState& state) : state_(state) {}
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
  PostgresState& state_;
};

class PostgresImageStore final : public ImageStore {
 public:
  explicit PostgresImageStore(PostgresState& state) : state_(state) {}
  void Write(const std::string& sha256, std::string_view bytes) override;
  std::optional<std::string> Read(const std::string& sha256) const override;
  void RemoveUnused(const std::string& sha256) override;
  uint64_t NumBytes() const override;

 private:
  PostgresState& state_;
};

class PostgresJobStore final : public JobStore {
 public:
  explicit PostgresJobStore(PostgresState& state) : state_(state) {}
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
  PostgresState& state_;
};

class PostgresTelemetryStore final : public TelemetryStore {
 public:
  explicit PostgresTelemetryStore(PostgresState& state) : state_(state) {}
  bool Put(const std::string& flight_id, const std::vector<TelemetryRow>& rows) override;
  std::vector<TelemetryRow> Recent(const std::string& flight_id,
                                   TelemetryKind kind,
                                   int max_num_rows) const override;
  TelemetryPair Around(const std::string& flight_id,
                       TelemetryKind kind,
                       int64_t timestamp_us) const override;

 private:
  struct Samples {
    std::string flight_id;
    const std::vector<TelemetryRow>& rows;
    bool is_stored = false;
  };
  void PutTogether(const std::vector<Samples*>& group);

  PostgresState& state_;
  GroupedWrites<Samples> grouped_;
};

class PostgresSiteStore final : public SiteStore {
 public:
  explicit PostgresSiteStore(PostgresState& state) : state_(state) {}
  std::unique_ptr<SiteTurn> TakeTurn() override;
  std::optional<SiteRow> Find(const std::string& site_id) const override;
  std::optional<SiteRow> FindWhole(const std::string& site_id) const override;
  std::vector<SiteRow> List(const std::optional<std::string>& flight_id,
                            const std::optional<BoundingBox>& box) const override;
  uint64_t Version() const override;
  std::vector<std::string> ListDependents(const std::string& site_id) const override;
  std::vector<std::string> ListDependentsOfMap(const std::string& map_id) const override;
  std::vector<std::string> ListUnchecked() const override;
  SharedRows<MapRow> ListMaps(const BoundingBox& box) const override;
  std::vector<std::string> ListAccepted(const BoundingBox& box) const override;
  SharedRows<RecallRow> ListRecallable(const BoundingBox& box) const override;
  int64_t CountRecallable() const override;
  bool HasRecallable(const std::string& flight_id) const override;
  RecallBounds BoundsOfRecallable() const override;
  int64_t CountOverruled(const BoundingBox& box) const override;

 private:
  PostgresState& state_;
};

class PostgresMapStore final : public MapStore {
 public:
  explicit PostgresMapStore(PostgresState& state) : state_(state) {}
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
  PostgresState& state_;
};

class PostgresObstacleStore final : public ObstacleStore {
 public:
  explicit PostgresObstacleStore(PostgresState& state) : state_(state) {}
  void Put(const std::vector<ObstacleRow>& obstacles, int64_t now_us) override;
  bool Delete(const std::string& id) override;
  void Merge(const ToldObstacles& told) override;
  std::optional<ObstacleRow> Find(const std::string& id) const override;
  std::vector<ObstacleRow> List() const override;
  uint64_t Version() const override;

 private:
  PostgresState& state_;
};

class PostgresChangeStore final : public ChangeStore {
 public:
  explicit PostgresChangeStore(PostgresState& state) : state_(state) {}
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
  void SetUnknownAbove(const std::vector<ChangeKey>& keys) override;
  void SetAllUnknownAbove(const std::string& except_origin) override;
  std::optional<FollowState> FindFollowState() const override;
  void PutFollowState(const FollowState& state) override;

 private:
  PostgresState& state_;
};

class PostgresClaimStore final : public ClaimStore {
 public:
  explicit PostgresClaimStore(PostgresState& state) : state_(state) {}
  bool IsShared() const override;
  std::optional<Claim> ClaimNext() override;
  std::vector<std::string> ListClaimed() const override;
  void Release(const std::string& flight_id) override;
  bool Renew() override;
  LeaseCounts CountLeases() const override;
  void Tell(const SharedEvent& event) override;
  std::vector<SharedEvent> ListTold(int64_t after_number, int limit) const override;
  int64_t LastTold() const override;
  void ForgetOldTold() override;

 private:
  PostgresState& state_;
};

}  // namespace freelsd
