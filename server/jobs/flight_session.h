// The engine's state of one flight.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/config.h"
#include "storage/storage.h"

namespace freelsd {

// The models that flights use, by the preset of their options.
struct GroundModels {
  GroundModel kinds;
  // Of Preset::kPaper.
  GroundModel paper;
  // SHA-256 of their files.
  std::string kinds_digest = {};
  std::string paper_digest = {};

  const GroundModel& For(Preset preset) const { return preset == Preset::kPaper ? paper : kinds; }
  const std::string& DigestFor(Preset preset) const {
    return preset == Preset::kPaper ? paper_digest : kinds_digest;
  }
};

// Holds a flight's Frontend, its statistics and its notes. The frontend thread passes frames to it;
// the backend thread takes snapshots. After a restart, the session is rebuilt from the stored
// frames, in the same order. It is flushed after the same frames (Frontend::Flush).
class FlightSession {
 public:
  // The flight's rig must be known.
  FlightSession(const FlightRow& flight, const GroundModels& ground_models);

  const FlightRequest& request() const { return request_; }
  const GeoPoint& origin() const { return rig_.origin; }
  // SHA-256 of the file of its grass model.
  const std::string& model_digest() const { return model_digest_; }
  FlightContext Context() const;

  // --- Frontend thread ---
  // Passes winds from telemetry to the frontend: those between the previous frame and the next one.
  // `next` is the metadata of the next frame.
  void GiveWinds(const Storage& storage, const Config& config, const FrameMeta& next);
  std::vector<FrameResult> Give(const FrameRow& row, const FrameMeta& meta, const cv::Mat& image);
  // Skips a frame that cannot be passed to the frontend.
  void Skip(int64_t sequence) { cursor_ = sequence; }
  std::vector<FrameResult> Flush(int64_t through_sequence);
  // Requests a flush after this frame, because the next frame may come much later.
  void AddFlushPoint(int64_t sequence);
  std::optional<int64_t> NextFlushPoint() const;
  // Collects the frontend's notes on frames, and passes each result to `store`. What one call does
  // not store, because `store` throws, comes first in the next.
  void StoreResults(const std::vector<FrameResult>& results,
                    const std::function<void(const FrameResult&)>& store);

  // --- Both threads ---
  // cursor: sequence number of the last frame passed in. flushed_through: sequence number of the
  // last frame before the latest flush. No frame up to this number waits in the engine.
  int64_t cursor() const { return cursor_; }
  int64_t flushed_through() const { return flushed_through_; }
  // True if a flush before `sequence` processed or rejected frames that still waited for
  // neighbours. A new session could process them better, because more neighbours have arrived.
  bool HasSettledBefore(int64_t sequence) const { return first_settled_at_ < sequence; }
  bool HasUnstoredResults() const { return has_unstored_results_; }
  // Regions, stages and warnings are stored as they are.
  bool IsStored() const { return num_steps_ == num_stored_steps_; }
  // With the sequence number of the last frame passed in before it was taken.
  std::pair<Snapshot, int64_t> TakeSnapshot();
  // When each frame's photograph was taken, by frame.
  CaptureTimes TimesOfFrames();
  void AddReports(const std::vector<StageReport>& reports);
  // Stores the flight's current regions, stages, warnings and ground altitude.
  void Store(Storage& storage);

 private:
  struct StageSum {
    double seconds = 0.0;
    int64_t count = 0;
  };
  struct NoteCount {
    std::string first_frame_id;
    int count = 0;
  };
  void StoreRegions(Storage& storage);
  std::string StagesJson(const std::string& stored_json);
  std::vector<std::string> NoteSentences();

  std::string flight_id_;
  FlightRequest request_;
  FlightRig rig_;
  std::string model_digest_;
  LocalFrame local_frame_;
  std::atomic<int64_t> cursor_{0};
  std::atomic<int64_t> flushed_through_{0};
  std::atomic<int64_t> first_settled_at_{std::numeric_limits<int64_t>::max()};
  std::atomic<bool> has_unstored_results_{false};
  // Frames given and flushes, and how many of them the last Store has seen.
  std::atomic<int64_t> num_steps_{0};
  std::atomic<int64_t> num_stored_steps_{0};
  std::set<int64_t> flush_points_;
  // Only the frontend thread uses it.
  std::deque<FrameResult> unstored_results_;
  // Latest timestamp of a frame that was passed in. Only the frontend thread uses it.
  std::optional<int64_t> last_frame_us_;

  // Guards frontend_ and times_.
  std::mutex frontend_mutex_;
  Frontend frontend_;
  CaptureTimes times_;
  // Guards stages_ and notes_.
  std::mutex statistics_mutex_;
  std::map<std::string, StageSum> stages_;
  std::map<std::string, NoteCount> notes_;
};

}  // namespace freelsd
