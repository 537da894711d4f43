#include <algorithm>

#include "storage/sqlite/arrivals.h"
#include "storage/sqlite/flight_rows.h"
#include "storage/sqlite/job_rows.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

FrameRow FrameRowOf(const Statement& statement) {
  FrameRow frame;
  frame.flight_id = statement.Text(0);
  frame.sequence = statement.Int(1);
  frame.id = statement.Text(2);
  frame.sha256 = statement.Text(3);
  frame.meta_json = statement.Text(4);
  frame.state = static_cast<FrameState>(statement.Int(5));
  frame.reason = statement.Text(6);
  frame.is_from_batch = statement.Int(7) != 0;
  frame.tags_json = statement.Text(8);
  frame.resolved_json = statement.Text(9);
  frame.arrived_at_us = statement.Int(10);
  return frame;
}

Statement SelectFrames(const Connection& connection, const std::string& which) {
  constexpr char kSelect[] =
      "SELECT flight_id, sequence, id, sha256, meta_json, state, reason, is_from_batch, tags_json, "
      "resolved_json, arrived_at_us FROM frames ";
  return connection.Prepare((kSelect + which).c_str());
}

int64_t LastSequence(const Connection& writer, const std::string& flight_id) {
  Statement statement =
      writer.Prepare("SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = ?1");
  statement.Bind(flight_id).Step();
  return statement.Int(0);
}

void InsertFrameRow(const Connection& writer, const FrameRow& frame, int64_t sequence) {
  writer
      .Prepare(
          "INSERT INTO frames (flight_id, sequence, id, sha256, meta_json, state, reason, "
          "is_from_batch, tags_json, resolved_json, arrived_at_us) "
          "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)")
      .Bind(frame.flight_id,
            sequence,
            frame.id,
            frame.sha256,
            frame.meta_json,
            static_cast<int>(frame.state),
            frame.reason,
            static_cast<int>(frame.is_from_batch),
            frame.tags_json,
            frame.resolved_json,
            std::max(frame.arrived_at_us, NextArrival(writer, frame.flight_id)))
      .Run();
}

}  // namespace

void SqliteFrameStore::Insert(const std::string& flight_id,
                              const std::vector<FrameRow>& frames,
                              const std::optional<JobRow>& job,
                              const FlightChange& change) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  int64_t sequence = LastSequence(state_.writer, flight_id);
  for (const FrameRow& frame : frames) {
    // The file may be gone: deleting another flight with the same image removes it.
    if (!state_.images.Has(frame.sha256)) {
      throw StorageError("insert frame " + frame.id, "its image file is missing");
    }
    InsertFrameRow(state_.writer, frame, ++sequence);
  }
  if (job) InsertJobRow(state_.writer, *job);
  if (change) ChangeFlightRow(state_.writer, flight_id, change);
  transaction.Commit();
}

std::optional<FrameRow> SqliteFrameStore::Find(const std::string& flight_id,
                                               const std::string& frame_id) const {
  const Reader reader(state_.readers);
  Statement statement = SelectFrames(*reader, "WHERE flight_id = ?1 AND id = ?2");
  if (!statement.Bind(flight_id, frame_id).Step()) return std::nullopt;
  return FrameRowOf(statement);
}

std::vector<FrameRow> SqliteFrameStore::List(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  Statement statement = SelectFrames(*reader, "WHERE flight_id = ?1 ORDER BY sequence");
  statement.Bind(flight_id);
  std::vector<FrameRow> frames;
  while (statement.Step()) frames.push_back(FrameRowOf(statement));
  return frames;
}

void SqliteFrameStore::ForEachResolved(
    const std::string& flight_id,
    const std::function<void(const std::string& resolved_json)>& take) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(
      "SELECT resolved_json FROM frames WHERE flight_id = ?1 AND resolved_json <> '' "
      "ORDER BY sequence");
  statement.Bind(flight_id);
  while (statement.Step()) take(statement.Text(0));
}

int64_t SqliteFrameStore::CountQueued() const {
  const Reader reader(state_.readers);
  Statement statement =
      reader->Prepare("SELECT count(*) FROM frames WHERE state = 0 AND is_from_batch = 0");
  statement.Step();
  return statement.Int(0);
}

std::optional<int64_t> SqliteFrameStore::OldestQueuedArrival() const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare("SELECT min(arrived_at_us) FROM frames WHERE state = 0");
  statement.Step();
  return statement.OptionalInt(0);
}

std::optional<FrameRow> SqliteFrameStore::Next(const std::string& flight_id,
                                               int64_t after_sequence) const {
  const Reader reader(state_.readers);
  Statement statement =
      SelectFrames(*reader, "WHERE flight_id = ?1 AND sequence > ?2 ORDER BY sequence LIMIT 1");
  if (!statement.Bind(flight_id, after_sequence).Step()) return std::nullopt;
  return FrameRowOf(statement);
}

std::vector<FrameRow> SqliteFrameStore::LastArrived(const std::string& flight_id,
                                                    int max_num_frames) const {
  const Reader reader(state_.readers);
  Statement statement =
      SelectFrames(*reader, "WHERE flight_id = ?1 ORDER BY sequence DESC LIMIT ?2");
  statement.Bind(flight_id, max_num_frames);
  std::vector<FrameRow> frames;
  while (statement.Step()) frames.push_back(FrameRowOf(statement));
  return frames;
}

std::optional<int64_t> SqliteFrameStore::NextQueuedSequence(const std::string& flight_id,
                                                            int64_t after_sequence) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(
      "SELECT sequence FROM frames WHERE flight_id = ?1 AND sequence > ?2 AND state = 0 "
      "ORDER BY sequence LIMIT 1");
  if (!statement.Bind(flight_id, after_sequence).Step()) return std::nullopt;
  return statement.Int(0);
}

void SqliteFrameStore::SetState(const std::string& flight_id,
                                const std::string& frame_id,
                                FrameState state,
                                const std::string& reason) {
  const auto lock = state_.LockForWriting();
  state_.writer
      .Prepare("UPDATE frames SET state = ?3, reason = ?4 WHERE flight_id = ?1 AND id = ?2")
      .Bind(flight_id, frame_id, static_cast<int>(state), reason)
      .Run();
}

void SqliteFrameStore::Resolve(const std::string& flight_id,
                               const std::string& frame_id,
                               const std::string& resolved_json,
                               const FlightChange& change) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  state_.writer.Prepare("UPDATE frames SET resolved_json = ?3 WHERE flight_id = ?1 AND id = ?2")
      .Bind(flight_id, frame_id, resolved_json)
      .Run();
  if (change) ChangeFlightRow(state_.writer, flight_id, change);
  transaction.Commit();
}

}  // namespace freelsd
