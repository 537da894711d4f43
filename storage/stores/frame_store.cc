#include <algorithm>

#include "storage/stores/stores.h"

namespace freelsd {
namespace {

FrameRow FrameRowOf(const Row& row) {
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

std::string SelectFrames(const std::string& which) {
  return "SELECT flight_id, sequence, id, sha256, meta_json, state, reason, is_from_batch, "
         "tags_json, resolved_json, arrived_at_us FROM frames " +
         which;
}

void InsertFrameRow(Database& writer, const Dialect& dialect, const FrameRow& frame) {
  const std::string& image = dialect.frame_image;
  const std::string column = image == "sha256" ? "" : ", " + image;
  writer.Change(
      "INSERT INTO frames (flight_id, sequence, id, sha256, meta_json, state, reason, "
      "is_from_batch, tags_json, resolved_json, arrived_at_us" +
          column + ") VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11" +
          (column.empty() ? ")" : ", $4)"),
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

void SqlFrameStore::Insert(const std::string& flight_id,
                           const std::vector<FrameRow>& frames,
                           const std::optional<JobRow>& job,
                           const FlightChange& change) {
  access_.Write([&](Writer& writer) {
    LockFlight(*writer, flight_id);
    int64_t sequence = writer->Int(
        "SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = $1", flight_id);
    int64_t next_us = NextArrival(*writer, flight_id);
    for (FrameRow frame : frames) {
      frame.sequence = ++sequence;
      frame.arrived_at_us = std::max(frame.arrived_at_us, next_us);
      next_us = frame.arrived_at_us + 1;
      InsertFrameRow(*writer, access_.dialect(), frame);
      // The file may be gone: deleting another flight with the same image removes it. Now that the
      // row refers to it, nobody does.
      if (!access_.HasImage(frame.sha256)) {
        throw StorageError("insert frame " + frame.id, "its image file is missing");
      }
    }
    if (job) InsertJobRow(*writer, *job);
    if (change) ChangeFlightRow(*writer, flight_id, change);
  });
}

void SqlFrameStore::Resolve(const std::string& flight_id,
                            const std::string& frame_id,
                            const std::string& resolved_json,
                            const FlightChange& change) {
  access_.Write([&](Writer& writer) {
    LockFlight(*writer, flight_id);
    writer->Change("UPDATE frames SET resolved_json = $3 WHERE flight_id = $1 AND id = $2",
                   flight_id,
                   frame_id,
                   resolved_json);
    if (change) ChangeFlightRow(*writer, flight_id, change);
  });
}

void SqlFrameStore::SetState(const std::string& flight_id,
                             const std::string& frame_id,
                             FrameState state,
                             const std::string& reason) {
  access_.Write([&](Writer& writer) {
    // Counts each frame once, also if a replay changes its state.
    writer->Change(
        "UPDATE flights SET num_rejected_frames = num_rejected_frames + (SELECT CASE WHEN $3 = 2 "
        "THEN 1 ELSE 0 END - CASE WHEN state = 2 THEN 1 ELSE 0 END FROM frames WHERE flight_id = "
        "$1 "
        "AND id = $2) WHERE id = $1 AND EXISTS (SELECT 1 FROM frames WHERE flight_id = $1 AND "
        "id = $2)",
        flight_id,
        frame_id,
        static_cast<int>(state));
    writer->Change("UPDATE frames SET state = $3, reason = $4 WHERE flight_id = $1 AND id = $2",
                   flight_id,
                   frame_id,
                   static_cast<int>(state),
                   reason);
    // A flight that goes on has not ended its workers.
    const std::string& forget = access_.dialect().forget_lost_workers;
    if (!forget.empty()) writer->Change(forget, flight_id);
  });
}

std::optional<FrameRow> SqlFrameStore::Find(const std::string& flight_id,
                                            const std::string& frame_id) const {
  return access_.Read([&](Database& database) {
    return database.First(
        FrameRowOf, SelectFrames("WHERE flight_id = $1 AND id = $2"), flight_id, frame_id);
  });
}

std::vector<FrameRow> SqlFrameStore::List(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.Each(
        FrameRowOf, SelectFrames("WHERE flight_id = $1 ORDER BY sequence"), flight_id);
  });
}

// `take` may read from the storage, so it is called without a connection.
void SqlFrameStore::ForEachResolved(
    const std::string& flight_id,
    const std::function<void(const std::string& resolved_json)>& take) const {
  constexpr int kNumAtOnce = 1000;
  int64_t after_sequence = 0;
  for (bool has_more = true; has_more;) {
    const std::vector<FrameRow> frames = access_.Read([&](Database& database) {
      return database.Each(
          [](const Row& row) {
            FrameRow frame;
            frame.sequence = row.Int(0);
            frame.resolved_json = row.Text(1);
            return frame;
          },
          "SELECT sequence, resolved_json FROM frames WHERE flight_id = $1 AND sequence > $2 AND "
          "resolved_json <> '' ORDER BY sequence LIMIT $3",
          flight_id,
          after_sequence,
          kNumAtOnce);
    });
    for (const FrameRow& frame : frames) take(frame.resolved_json);
    has_more = frames.size() == kNumAtOnce;
    if (has_more) after_sequence = frames.back().sequence;
  }
}

int64_t SqlFrameStore::CountQueued() const {
  return access_.Read([](Database& database) {
    return database.Int("SELECT count(*) FROM frames WHERE state = 0 AND is_from_batch = false");
  });
}

std::optional<int64_t> SqlFrameStore::OldestQueuedArrival() const {
  return access_.Read([](Database& database) {
    return *database.First([](const Row& row) { return row.OptionalInt(0); },
                           "SELECT min(arrived_at_us) FROM frames WHERE state = 0");
  });
}

std::optional<FrameRow> SqlFrameStore::Next(const std::string& flight_id,
                                            int64_t after_sequence) const {
  return access_.Read([&](Database& database) {
    return database.First(
        FrameRowOf,
        SelectFrames("WHERE flight_id = $1 AND sequence > $2 ORDER BY sequence LIMIT 1"),
        flight_id,
        after_sequence);
  });
}

std::vector<FrameRow> SqlFrameStore::LastArrived(const std::string& flight_id,
                                                 int max_num_frames) const {
  return access_.Read([&](Database& database) {
    return database.Each(FrameRowOf,
                         SelectFrames("WHERE flight_id = $1 ORDER BY sequence DESC LIMIT $2"),
                         flight_id,
                         max_num_frames);
  });
}

std::optional<int64_t> SqlFrameStore::NextQueuedSequence(const std::string& flight_id,
                                                         int64_t after_sequence) const {
  return access_.Read([&](Database& database) {
    return database.First(
        [](const Row& row) { return row.Int(0); },
        "SELECT sequence FROM frames WHERE flight_id = $1 AND sequence > $2 AND state = 0 "
        "ORDER BY sequence LIMIT 1",
        flight_id,
        after_sequence);
  });
}

}  // namespace freelsd
