// What survives: flights, frames, jobs, regions, sites and their maps, in SQLite and image files
// named by SHA-256. Knows nothing of the engine: rows, JSON text, blobs.
//
// Durable: a call that returns has been synced (WAL, synchronous=FULL; image files are fsynced,
// renamed and their folder fsynced before their row is committed). One writer; readers never wait
// for it. All methods are thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

enum class StorageFault { kOther, kFull, kDamaged, kNewer };

// What SQL step or file operation failed, and why.
class StorageError : public std::runtime_error {
 public:
  StorageError(const std::string& step,
               const std::string& reason,
               StorageFault fault = StorageFault::kOther);
  // kFull: no space left. kDamaged: the database's file is not what was written. kNewer: a newer
  // program wrote it.
  StorageFault fault;
};

struct FlightRow {
  std::string id;
  std::string name;
  std::string request_json;
  // Resolved once the first frame is known; JSON text of camera, body_from_camera, origin.
  std::string rig_json;
  std::string warnings_json = "[]";
  std::string stages_json = "{}";
  int64_t created_at_us = 0;
  int64_t num_rejected_frames = 0;
  bool has_failed = false;
  // Of the ground below the first frame, in the flight's datum, once the engine has an estimate.
  std::optional<double> ground_altitude_m;
  // Its images were removed to make room: it is over, but its regions and sites stay.
  bool has_retired_images = false;
};

enum class FrameState { kQueued, kProcessed, kRejected };

struct FrameRow {
  // Order of processing within the flight.
  int64_t sequence = 0;
  std::string flight_id;
  std::string id;
  std::string sha256;
  // What was sent with it, and what the image says of itself.
  std::string meta_json;
  std::string tags_json = "{}";
  // Both and telemetry together, as the engine took it; empty before.
  std::string resolved_json;
  FrameState state = FrameState::kQueued;
  std::string reason;
  // Batches are outside the limit of the frame queue.
  bool is_from_batch = false;
};

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };

struct JobRow {
  std::string id;
  std::string kind;  // "batch" or "finish"
  std::string flight_id;
  JobState state = JobState::kQueued;
  double progress_ratio = 0.0;
  std::string stage;
  std::string detail_json = "{}";
  int64_t created_at_us = 0;
};

enum class TelemetryKind { kPosition, kAttitude, kWind };

// position: latitude, longitude (deg), altitude (m); attitude: ned_from_body w, x, y, z; wind:
// east, north (m/s), where the air moves to.
struct TelemetryRow {
  TelemetryKind kind = TelemetryKind::kPosition;
  int64_t timestamp_us = 0;
  std::array<double, 4> values{};
};

// A box with west > east crosses the antimeridian.
struct BoundingBox {
  double west_deg, south_deg, east_deg, north_deg;
};

// What emergency recall needs of a site before it reads the rest.
struct RecallData {
  bool is_landable = false;  // else unverified
  double altitude_m = 0.0;   // of the touchdown, in altitude_datum
  std::string altitude_datum = "unknown";
  double score = 0.0;
  std::string aircraft_json = "{}";
};

struct RecallRow {
  std::string site_id;
  std::string flight_id;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  int64_t updated_at_us = 0;
  int64_t seen_at_us = 0;
  RecallData data;
};

// What recall goes through, thousands at a time.
template <typename Row>
using SharedRows = std::vector<std::shared_ptr<const Row>>;

struct SiteRow {
  std::string id;
  std::string flight_id;
  int64_t region_id = 0;
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  // GeoJSON feature, without rank.
  std::string feature_json;
  // FeatureCollection of the approach; empty where there is none.
  std::string approach_json;
  // What planning anew needs: region, aircraft, origin, datum.
  std::string replan_json;
  int64_t updated_at_us = 0;
  // When its ground was last photographed: what decides which of two sites tells of today.
  int64_t seen_at_us = 0;
  // Its verdict tells of the ground itself, so it may supersede what was seen there before.
  bool is_evidence = false;
  // Nothing: never to be recalled (rejected, or no terrain was seen).
  std::optional<RecallData> recall;
  // What the map covers; nothing: the touchdown alone.
  std::optional<BoundingBox> map_box;
  // The site that a later look at the same ground gave.
  std::optional<std::string> superseded_by;
};

// What bounds the reach of any stored site.
struct RecallBounds {
  double min_altitude_m = 0.0;
  // Each that a site that can be recalled was planned for, once.
  std::vector<std::string> aircraft_jsons;
};

class Storage {
 public:
  // Creates the folder and schema, or opens them; image files that no frame names are removed. A
  // damaged database is set aside, with its images, and a new one begun with the sites of their
  // second copy. Throws StorageError when another process has the folder, or a newer program wrote
  // it; everything in it stays as it is then.
  explicit Storage(const std::filesystem::path& folder);
  ~Storage();
  // For uploads that are not acknowledged yet; emptied at start.
  std::filesystem::path SpoolFolder() const;

  // Flights.
  void InsertFlight(const FlightRow& flight);
  // Reads, changes and writes the row in one transaction: all but id, request_json, created_at_us.
  // False where there is no such flight.
  using FlightChange = std::function<void(FlightRow& flight)>;
  bool ChangeFlight(const std::string& flight_id, const FlightChange& change);
  std::optional<FlightRow> FindFlight(const std::string& flight_id) const;
  std::vector<FlightRow> ListFlights() const;
  // Sites stay unless forget_sites; image files no frame needs any more are removed.
  bool DeleteFlight(const std::string& flight_id, bool forget_sites);

  // Frames. The bytes are written (once per SHA-256) before the rows; all rows in one commit.
  void WriteImage(const std::string& sha256, std::string_view bytes);
  std::optional<std::string> ReadImage(const std::string& sha256) const;
  // Takes back an image that was written for nothing; one that a frame names stays.
  void RemoveUnusedImage(const std::string& sha256);
  // Frames of one flight, the job that waits for them, and what they change of the flight, in one
  // commit. Assigns sequence numbers in the given order. Throws StorageError, and stores nothing,
  // where a frame id exists already or an image file does not.
  void InsertFrames(const std::string& flight_id,
                    const std::vector<FrameRow>& frames,
                    const std::optional<JobRow>& job = std::nullopt,
                    const FlightChange& change = {});
  std::optional<FrameRow> FindFrame(const std::string& flight_id,
                                    const std::string& frame_id) const;
  std::vector<FrameRow> ListFrames(const std::string& flight_id) const;  // by sequence
  // The same, nothing but what the engine took of each frame that it took already.
  void ForEachResolved(const std::string& flight_id,
                       const std::function<void(const std::string& resolved_json)>& take) const;
  struct FrameCounts {
    int64_t received = 0, processed = 0, rejected = 0;
  };
  FrameCounts CountFrames(const std::string& flight_id) const;
  // Of all flights, without those of batches.
  int64_t CountQueuedFrames() const;
  // Oldest flight first.
  std::vector<std::string> FlightsWithQueuedFrames() const;
  // Of the flight the first frame after `after_sequence`, whatever its state.
  std::optional<FrameRow> NextFrame(const std::string& flight_id, int64_t after_sequence) const;
  // By sequence.
  std::optional<FrameRow> LastFrame(const std::string& flight_id) const;
  // Sequence number of the flight's first queued frame after `after_sequence`.
  std::optional<int64_t> NextQueuedSequence(const std::string& flight_id,
                                            int64_t after_sequence) const;
  void SetFrameState(const std::string& flight_id,
                     const std::string& frame_id,
                     FrameState state,
                     const std::string& reason);
  // What the engine takes of the frame from now on, and what that changes of the flight.
  void ResolveFrame(const std::string& flight_id,
                    const std::string& frame_id,
                    const std::string& resolved_json,
                    const FlightChange& change = {});
  uint64_t NumImageBytes() const;
  // Removes the flight's images, unless other flights need them, and marks it.
  void RetireImages(const std::string& flight_id);

  // Telemetry of a flight, all in one commit; what comes again replaces what was there.
  void PutTelemetry(const std::string& flight_id, const std::vector<TelemetryRow>& rows);
  // The last at or before, and the first at or after a time.
  struct TelemetryPair {
    std::optional<TelemetryRow> before, after;
  };
  TelemetryPair TelemetryAround(const std::string& flight_id,
                                TelemetryKind kind,
                                int64_t timestamp_us) const;

  // Jobs.
  void InsertJob(const JobRow& job);
  // State, progress, stage, detail; a job that is done, failed or cancelled stays so.
  void UpdateJob(const JobRow& job);
  std::optional<JobRow> FindJob(const std::string& job_id) const;
  std::vector<JobRow> ListJobs() const;                                // newest first, at most 1000
  std::vector<JobRow> ListJobsOf(const std::string& flight_id) const;  // newest first, all
  std::vector<JobRow> ListUnfinishedJobs() const;  // queued or running, oldest first
  bool DeleteJob(const std::string& job_id);

  // Regions: the whole snapshot of a flight at once.
  struct RegionRow {
    int64_t id = 0;
    std::string feature_json;
    std::string history_json;
  };
  void ReplaceRegions(const std::string& flight_id, const std::vector<RegionRow>& regions);
  std::vector<RegionRow> ListRegions(const std::string& flight_id) const;
  int64_t CountRegions(const std::string& flight_id) const;

  // Sites: inserted or replaced by id, with their map (empty: none), in one commit. Each is kept
  // twice: where the database is damaged, sites are read from their second copy. `supersedes`: ids
  // of sites on the same ground, which are not recalled while this one is there.
  void PutSite(const SiteRow& site,
               std::string_view map_blob,
               const std::vector<std::string>& supersedes = {});
  std::optional<SiteRow> FindSite(const std::string& site_id) const;
  std::vector<SiteRow> ListSites(const std::optional<std::string>& flight_id,
                                 const std::optional<BoundingBox>& box) const;
  int64_t CountSites(const std::string& flight_id) const;
  std::optional<std::string> ReadSiteMap(const std::string& site_id) const;
  RecallBounds BoundsOfRecallable() const;
  // Sites that can be recalled, their map or touchdown in the box.
  SharedRows<RecallRow> ListRecallable(const BoundingBox& box) const;
  int64_t CountRecallable() const;
  // Sites that could be recalled, had not a later one rejected their ground.
  int64_t CountOverruled(const BoundingBox& box) const;
  // Anew; nothing: it is superseded no more.
  void SetSupersededBy(const std::string& site_id, const std::optional<std::string>& newer_id);
  // Id and time of sites, also rejected ones, whose map may lie in the box.
  struct MapRow {
    std::string site_id;
    int64_t updated_at_us = 0;
    std::string altitude_datum;
  };
  SharedRows<MapRow> ListMaps(const BoundingBox& box) const;
  bool DeleteSite(const std::string& site_id);

  // Whether a write would work now: nothing, or why not.
  std::optional<std::string> WhyNotWritable() const;
  // The database's file is damaged: from now on nothing is written, sites are read from their
  // second copy, and the next start sets it aside. Also called by a check that runs beside.
  void MarkDamaged(const std::string& why) const;
  // What an operator must know: damage, and what was set aside at this start.
  std::vector<std::string> Notices() const;

 private:
  struct State;  // storage/state.h
  static std::unique_ptr<State> Opened(const std::filesystem::path& folder);
  std::unique_ptr<State> state_;
};

}  // namespace freelsd
