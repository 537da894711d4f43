// Frames of flights, in the order of processing.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "storage/flight_store.h"
#include "storage/job_store.h"

namespace freelsd {

enum class FrameState { kQueued, kProcessed, kRejected };

struct FrameRow {
  // Order of processing within the flight.
  int64_t sequence = 0;
  std::string flight_id;
  std::string id;
  std::string sha256;
  // Metadata that the client sent with the frame, and metadata from the image's own tags.
  std::string meta_json;
  std::string tags_json = "{}";
  // The metadata that the engine uses: meta_json and tags_json, merged with telemetry. Empty until
  // they are merged.
  std::string resolved_json;
  FrameState state = FrameState::kQueued;
  std::string reason;
  // Frames of batches do not count against the limit of the frame queue.
  bool is_from_batch = false;
  // When the server received the frame, as in TelemetryRow. Insert increases the value as
  // TelemetryStore::Put does.
  int64_t arrived_at_us = 0;
};

// Invariants: the sequence numbers of a flight run from 1 without a gap, and the image of each
// frame is stored before the frame.
class FrameStore {
 public:
  virtual ~FrameStore() = default;
  FrameStore(const FrameStore&) = delete;
  FrameStore& operator=(const FrameStore&) = delete;

  // Inserts frames of one flight, inserts the job that waits for them, and applies `change` to the
  // flight, all in one commit. Assigns sequence numbers in the given order. Throws StorageError and
  // stores nothing if a frame id exists already or an image is missing. Writers of one flight, also
  // in other processes, take turns.
  virtual void Insert(const std::string& flight_id,
                      const std::vector<FrameRow>& frames,
                      const std::optional<JobRow>& job = std::nullopt,
                      const FlightChange& change = {}) = 0;
  // Sets the frame's resolved_json and applies `change` to the flight, in one commit.
  virtual void Resolve(const std::string& flight_id,
                       const std::string& frame_id,
                       const std::string& resolved_json,
                       const FlightChange& change = {}) = 0;
  // Also keeps the flight's num_rejected_frames.
  virtual void SetState(const std::string& flight_id,
                        const std::string& frame_id,
                        FrameState state,
                        const std::string& reason) = 0;

  virtual std::optional<FrameRow> Find(const std::string& flight_id,
                                       const std::string& frame_id) const = 0;
  virtual std::vector<FrameRow> List(const std::string& flight_id) const = 0;  // by sequence
  // Calls `take` with each resolved_json that is not empty, by sequence.
  virtual void ForEachResolved(
      const std::string& flight_id,
      const std::function<void(const std::string& resolved_json)>& take) const = 0;
  // Queued frames of all flights, without frames of batches.
  virtual int64_t CountQueued() const = 0;
  // When the frame arrived that waits longest, those of batches included. Nothing if none waits.
  virtual std::optional<int64_t> OldestQueuedArrival() const = 0;
  // The flight's first frame after `after_sequence`, whatever its state.
  virtual std::optional<FrameRow> Next(const std::string& flight_id,
                                       int64_t after_sequence) const = 0;
  // The flight's frames with the highest sequence numbers, the last one first.
  virtual std::vector<FrameRow> LastArrived(const std::string& flight_id,
                                            int max_num_frames) const = 0;
  // Sequence number of the flight's first queued frame after `after_sequence`.
  virtual std::optional<int64_t> NextQueuedSequence(const std::string& flight_id,
                                                    int64_t after_sequence) const = 0;

 protected:
  FrameStore() = default;
};

}  // namespace freelsd
