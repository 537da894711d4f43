#include <algorithm>

#include "storage/postgres/flight_rows.h"
#include "storage/postgres/job_rows.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr char kSelectFrames[] =
    "SELECT flight_id, sequence, id, sha256, meta_json, state, reason, is_from_batch, "
    "tags_json, resolved_json, arrived_at_us FROM frames ";

FrameRow FrameRowOf(const PostgresRow& row) {
  FrameRow frame;
  frame.flight_id = row.Text(0);
  frame.sequence = row.Int(1);
  frame.id = row.Text(2);
  frame.sha256 = row.Text(3);
  frame.meta_json = row.Text(4);
  frame.state = static_cast<FrameState>(row.Int(5));
  frame.reason = row.Text(6);
  frame.is_from_batch = row.Bool(7);
  frame.tags_json = row.Text(8);
  frame.resolved_json = row.Text(9);
  frame.arrived_at_us = row.Int(10);
  return frame;
}

std::optional<FrameRow> FirstOf(const PostgresRows& rows) {
  if (rows.empty()) return std::nullopt;
  return FrameRowOf(rows[0]);
}

int64_t LastSequence(PostgresConnection& writer, const std::string& flight_id) {
  return writer
      .Run("SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = $1", flight_id)[0]
      .Int(0);
}

void InsertFrame(PostgresConnection& writer, const FrameRow& frame) {
  writer.Run(
      "INSERT INTO frames (flight_id, sequence, id, sha256, stored_image, meta_json, state, "
      "reason, is_from_batch, tags_json, resolved_json, arrived_at_us) "
      "VALUES ($1, $2, $3, $4, $4, $5, $6, $7, $8, $9, $10, $11)",
      frame.flight_id,
      frame.sequence,
      frame.id,
      frame.sha256,
      frame.meta_json,
      static_cast<int>(frame.state),
      frame.reason,
      frame.is_from_batch,
      frame.tags_json,
      frame.resolved_json,
      frame.arrived_at_us);
}

}  // namespace

void PostgresFrameStore::Insert(const std::string& flight_id,
                                const std::vector<FrameRow>& frames,
                                const std::optional<JobRow>& job,
                                const FlightChange& change) {
  PostgresWrite writer(state_);
  LockFlight(*writer, flight_id);
  int64_t sequence = LastSequence(*writer, flight_id);
  int64_t next_us = NextArrivalsOf(*writer, {flight_id}).at(flight_id);
  for (FrameRow frame : frames) {
    frame.sequence = ++sequence;
    frame.arrived_at_us = std::max(frame.arrived_at_us, next_us);
    next_us = frame.arrived_at_us + 1;
    // The reference locks the image's row until the commit, so its file stays.
    InsertFrame(*writer, frame);
    if (!state_.images.Has(frame.sha256)) {
      throw StorageError("insert frame " + frame.id, "its image file is missing");
    }
  }
  if (job) InsertJob(*writer, *job);
  if (change) ChangeFlight(*writer, flight_id, change);
  writer.Commit();
}

void PostgresFrameStore::Resolve(const std::string& flight_id,
                                 const std::string& frame_id,
                                 const std::string& resolved_json,
                                 const FlightChange& change) {
  PostgresWrite writer(state_);
  LockFlight(*writer, flight_id);
  writer->Run("UPDATE frames SET resolved_json = $3 WHERE flight_id = $1 AND id = $2",
              flight_id,
              frame_id,
              resolved_json);
  if (change) ChangeFlight(*writer, flight_id, change);
  writer.Commit();
}

void PostgresFrameStore::SetState(const std::string& flight_id,
                                  const std::string& frame_id,
                                  FrameState state,
                                  const std::string& reason) {
  PostgresWrite writer(state_);
  writer->Run("UPDATE frames SET state = $3, reason = $4 WHERE flight_id = $1 AND id = $2",
              flight_id,
              frame_id,
              static_cast<int>(state),
              reason);
  // A flight that goes on has not ended its workers.
  writer->Run("UPDATE claims SET num_lost = 0 WHERE flight_id = $1 AND num_lost > 0", flight_id);
  writer.Commit();
}

std::optional<FrameRow> PostgresFrameStore::Find(const std::string& flight_id,
                                                 const std::string& frame_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return FirstOf(connection.Run(
        std::string(kSelectFrames) + "WHERE flight_id = $1 AND id = $2", flight_id, frame_id));
  });
}

std::vector<FrameRow> PostgresFrameStore::List(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(std::string(kSelectFrames) + "WHERE flight_id = $1 ORDER BY sequence", flight_id)
        .Each(FrameRowOf);
  });
}

void PostgresFrameStore::ForEachResolved(
    const std::string& flight_id,
    const std::function<void(const std::string& resolved_json)>& take) const {
  // `take` may read from the storage, so it is called without a connection.
  const PostgresRows rows = state_.Read([&](PostgresConnection& connection) {
    return connection.Run(
        "SELECT resolved_json FROM frames WHERE flight_id = $1 AND resolved_json <> '' "
        "ORDER BY sequence",
        flight_id);
  });
  for (int row = 0; row < rows.size(); ++row) take(rows[row].Text(0));
}

int64_t PostgresFrameStore::CountQueued() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT count(*) FROM frames WHERE state = 0 AND NOT is_from_batch")[0]
        .Int(0);
  });
}

std::optional<int64_t> PostgresFrameStore::OldestQueuedArrival() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT min(arrived_at_us) FROM frames WHERE state = 0")[0].OptionalInt(
        0);
  });
}

std::optional<FrameRow> PostgresFrameStore::Next(const std::string& flight_id,
                                                 int64_t after_sequence) const {
  return state_.Read([&](PostgresConnection& connection) {
    return FirstOf(
        connection.Run(std::string(kSelectFrames) +
                           "WHERE flight_id = $1 AND sequence > $2 ORDER BY sequence LIMIT 1",
                       flight_id,
                       after_sequence));
  });
}

std::vector<FrameRow> PostgresFrameStore::LastArrived(const std::string& flight_id,
                                                      int max_num_frames) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(std::string(kSelectFrames) + "WHERE flight_id = $1 ORDER BY sequence DESC LIMIT $2",
             flight_id,
             max_num_frames)
        .Each(FrameRowOf);
  });
}

std::optional<int64_t> PostgresFrameStore::NextQueuedSequence(const std::string& flight_id,
                                                              int64_t after_sequence) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<int64_t> {
    const PostgresRows rows = connection.Run(
        "SELECT sequence FROM frames WHERE flight_id = $1 AND sequence > $2 AND state = 0 "
        "ORDER BY sequence LIMIT 1",
        flight_id,
        after_sequence);
    if (rows.empty()) return std::nullopt;
    return rows[0].Int(0);
  });
}

}  // namespace freelsd
