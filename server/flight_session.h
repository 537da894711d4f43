// The engine's memory of one flight, and what it has to tell of it.
#pragma once

#include <atomic>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "api/api.h"
#include "storage/storage.h"

namespace freelsd {

// The frontend thread gives frames; the backend thread takes snapshots. A flight's session is built
// again after a restart by giving its stored frames in order, with the same flushes.
class FlightSession {
 public:
  // The flight's rig must be resolved.
  FlightSession(const FlightRow& flight, const Classifier& classifier);

  const FlightRequest& request() const { return request_; }
  const GeoPoint& origin() const { return rig_.origin; }
  FlightContext Context() const;

  // --- Frontend thread ---
  std::vector<FrameResult> Give(const FrameRow& row, const cv::Mat& image);
  // Passes over a frame that cannot be given.
  void Skip(int64_t sequence) { cursor_ = sequence; }
  std::vector<FrameResult> Flush(int64_t through_sequence);
  // No more frames are to be expected after this one for a while: flush behind it.
  void AddFlushPoint(int64_t sequence);
  std::optional<int64_t> NextFlushPoint() const;
  // What the frontend said of frames.
  void AddNotes(const std::vector<FrameResult>& results);

  // --- Both ---
  // Sequence number of the last frame given, and up to which no frame waits in the engine any more.
  int64_t cursor() const { return cursor_; }
  int64_t flushed_through() const { return flushed_through_; }
  // Whether a flush before this one decided on frames that waited for their neighbours: with those
  // that came since, they could be decided better.
  bool HasSettledBefore(int64_t sequence) const { return first_settled_at_ < sequence; }
  Snapshot TakeSnapshot();
  void AddReports(const std::vector<StageReport>& reports);
  // Brings regions, stages, warnings and the ground's height of the flight up to date in storage.
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
  LocalFrame local_frame_;
  std::atomic<int64_t> cursor_{0};
  std::atomic<int64_t> flushed_through_{0};
  std::atomic<int64_t> first_settled_at_{std::numeric_limits<int64_t>::max()};
  std::set<int64_t> flush_points_;

  std::mutex frontend_mutex_;
  Frontend frontend_;
  std::mutex statistics_mutex_;
  std::map<std::string, StageSum> stages_;
  std::map<std::string, NoteCount> notes_;
};

}  // namespace freelsd
