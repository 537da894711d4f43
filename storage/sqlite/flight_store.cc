#include <limits>

#include "storage/sqlite/flight_rows.h"
#include "storage/sqlite/state.h"
#include "storage/sqlite/stores.h"

namespace freelsd {
namespace {

constexpr int kNumFlightColumns = 11;

Statement SelectFlights(const Connection& connection, const std::string& which) {
  constexpr char kSelect[] =
      "SELECT id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
      "num_rejected_frames, has_failed, ground_altitude_m, has_retired_images FROM flights ";
  return connection.Prepare((kSelect + which).c_str());
}

FlightRow RowOf(const Statement& statement) {
  FlightRow flight;
  flight.id = statement.Text(0);
  flight.name = statement.Text(1);
  flight.request_json = statement.Text(2);
  flight.rig_json = statement.Text(3);
  flight.warnings_json = statement.Text(4);
  flight.stages_json = statement.Text(5);
  flight.created_at_us = statement.Int(6);
  flight.num_rejected_frames = statement.Int(7);
  flight.has_failed = statement.Int(8) != 0;
  flight.ground_altitude_m = statement.OptionalReal(9);
  flight.has_retired_images = statement.Int(10) != 0;
  return flight;
}

// Each count comes from an index. The rowid is the order of insertion.
Statement SelectSummaries(const Connection& connection, const std::string& which) {
  constexpr char kSelect[] =
      "SELECT id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
      "num_rejected_frames, has_failed, ground_altitude_m, has_retired_images, "
      // Sequence numbers run from 1 without a gap.
      "(SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = flights.id), "
      "(SELECT count(*) FROM frames WHERE flight_id = flights.id AND state = 0), "
      "(SELECT count(*) FROM regions WHERE flight_id = flights.id), "
      "(SELECT count(*) FROM sites WHERE flight_id = flights.id), "
      "EXISTS (SELECT 1 FROM jobs WHERE flight_id = flights.id AND state < 2), "
      "rowid FROM flights ";
  return connection.Prepare((kSelect + which).c_str());
}

FlightSummary SummaryOf(const Statement& statement) {
  FlightSummary summary;
  summary.flight = RowOf(statement);
  summary.num_frames = statement.Int(kNumFlightColumns);
  summary.num_queued_frames = statement.Int(kNumFlightColumns + 1);
  summary.num_regions = statement.Int(kNumFlightColumns + 2);
  summary.num_sites = statement.Int(kNumFlightColumns + 3);
  summary.has_unfinished_job = statement.Int(kNumFlightColumns + 4) != 0;
  summary.number = statement.Int(kNumFlightColumns + 5);
  return summary;
}

std::optional<FlightRow> FindFlightRow(const Connection& connection, const std::string& flight_id) {
  Statement statement = SelectFlights(connection, "WHERE id = ?1");
  if (!statement.Bind(flight_id).Step()) return std::nullopt;
  return RowOf(statement);
}

// Images that only frames of this flight name.
std::vector<std::string> OwnImages(const Connection& writer, const std::string& flight_id) {
  std::vector<std::string> images;
  Statement statement = writer.Prepare(
      "SELECT DISTINCT sha256 FROM frames AS mine WHERE flight_id = ?1 AND NOT EXISTS ("
      "SELECT 1 FROM frames WHERE sha256 = mine.sha256 AND flight_id <> ?1) AND NOT EXISTS ("
      "SELECT 1 FROM photo_tiles WHERE sha256 = mine.sha256)");
  statement.Bind(flight_id);
  while (statement.Step()) images.push_back(statement.Text(0));
  return images;
}

}  // namespace

std::optional<std::vector<std::string>> DeleteFlightRow(const Connection& writer,
                                                        const std::string& flight_id) {
  std::vector<std::string> images = OwnImages(writer, flight_id);
  writer.Prepare("DELETE FROM flights WHERE id = ?1").Bind(flight_id).Run();
  if (writer.NumChanges() == 0) return std::nullopt;
  return images;
}

bool ChangeFlightRow(const Connection& writer,
                     const std::string& flight_id,
                     const FlightChange& change) {
  std::optional<FlightRow> flight = FindFlightRow(writer, flight_id);
  if (!flight) return false;
  change(*flight);
  writer
      .Prepare(
          "UPDATE flights SET name = ?2, rig_json = ?3, warnings_json = ?4, stages_json = ?5, "
          "num_rejected_frames = ?6, has_failed = ?7, ground_altitude_m = ?8, "
          "has_retired_images = ?9 WHERE id = ?1")
      .Bind(flight_id,
            flight->name,
            flight->rig_json,
            flight->warnings_json,
            flight->stages_json,
            flight->num_rejected_frames,
            static_cast<int>(flight->has_failed),
            flight->ground_altitude_m,
            static_cast<int>(flight->has_retired_images))
      .Run();
  return true;
}

void SqliteFlightStore::Insert(const FlightRow& flight) {
  const auto lock = state_.LockForWriting();
  state_.writer
      .Prepare(
          "INSERT INTO flights VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
          "?11)")
      .Bind(flight.id,
            flight.name,
            flight.request_json,
            flight.rig_json,
            flight.warnings_json,
            flight.stages_json,
            flight.created_at_us,
            flight.num_rejected_frames,
            static_cast<int>(flight.has_failed),
            flight.ground_altitude_m,
            static_cast<int>(flight.has_retired_images))
      .Run();
}

bool SqliteFlightStore::Change(const std::string& flight_id, const FlightChange& change) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  const bool is_there = ChangeFlightRow(state_.writer, flight_id, change);
  transaction.Commit();
  return is_there;
}

std::optional<FlightRow> SqliteFlightStore::Find(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  return FindFlightRow(*reader, flight_id);
}

std::vector<FlightRow> SqliteFlightStore::List() const {
  const Reader reader(state_.readers);
  Statement statement = SelectFlights(*reader, "ORDER BY created_at_us DESC, id");
  std::vector<FlightRow> flights;
  while (statement.Step()) flights.push_back(RowOf(statement));
  return flights;
}

std::optional<FlightSummary> SqliteFlightStore::FindSummary(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  Statement statement = SelectSummaries(*reader, "WHERE id = ?1");
  if (!statement.Bind(flight_id).Step()) return std::nullopt;
  return SummaryOf(statement);
}

FlightPage SqliteFlightStore::ListPage(size_t limit, std::optional<int64_t> before_number) const {
  const Reader reader(state_.readers);
  Statement statement = SelectSummaries(*reader, "WHERE rowid < ?1 ORDER BY rowid DESC LIMIT ?2");
  statement.Bind(before_number.value_or(std::numeric_limits<int64_t>::max()),
                 static_cast<int64_t>(limit) + 1);
  FlightPage page;
  while (statement.Step()) page.flights.push_back(SummaryOf(statement));
  page.has_more = page.flights.size() > limit;
  if (page.has_more) page.flights.pop_back();
  return page;
}

int64_t SqliteFlightStore::Count() const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare("SELECT count(*) FROM flights");
  statement.Step();
  return statement.Int(0);
}

std::vector<std::string> SqliteFlightStore::ListWithQueuedFrames() const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(
      "SELECT id FROM flights WHERE EXISTS (SELECT 1 FROM frames WHERE flight_id = flights.id AND "
      "state = 0) ORDER BY created_at_us, id");
  std::vector<std::string> flights;
  while (statement.Step()) flights.push_back(statement.Text(0));
  return flights;
}

bool SqliteFlightStore::RetireImages(const std::string& flight_id) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  Statement in_use = state_.writer.Prepare(
      "SELECT 1 FROM frames WHERE flight_id = ?1 AND state = 0 "
      "UNION ALL SELECT 1 FROM jobs WHERE flight_id = ?1 AND state < 2");
  if (in_use.Bind(flight_id).Step()) return false;
  const std::vector<std::string> images = OwnImages(state_.writer, flight_id);
  ChangeFlightRow(
      state_.writer, flight_id, [](FlightRow& flight) { flight.has_retired_images = true; });
  transaction.Commit();
  for (const std::string& sha256 : images) state_.images.Remove(sha256);
  return true;
}

bool SqliteFlightStore::Delete(const std::string& flight_id) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  const auto images = DeleteFlightRow(state_.writer, flight_id);
  if (!images) return false;
  transaction.Commit();
  for (const std::string& sha256 : *images) state_.images.Remove(sha256);
  return true;
}

void SqliteFlightStore::ReplaceRegions(const std::string& flight_id,
                                       const std::vector<RegionRow>& regions) {
  const auto lock = state_.LockForWriting();
  Transaction transaction(state_.writer);
  state_.writer.Prepare("DELETE FROM regions WHERE flight_id = ?1").Bind(flight_id).Run();
  int64_t rank = 0;
  for (const RegionRow& region : regions) {
    state_.writer.Prepare("INSERT INTO regions VALUES (?1, ?2, ?3, ?4, ?5)")
        .Bind(flight_id, region.id, rank++, region.feature_json, region.history_json)
        .Run();
  }
  transaction.Commit();
}

std::vector<RegionRow> SqliteFlightStore::ListRegions(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare(
      "SELECT id, feature_json, history_json FROM regions WHERE flight_id = ?1 ORDER BY rank");
  statement.Bind(flight_id);
  std::vector<RegionRow> regions;
  while (statement.Step()) {
    regions.push_back({statement.Int(0), statement.Text(1), statement.Text(2)});
  }
  return regions;
}

int64_t SqliteFlightStore::CountRegions(const std::string& flight_id) const {
  const Reader reader(state_.readers);
  Statement statement = reader->Prepare("SELECT count(*) FROM regions WHERE flight_id = ?1");
  statement.Bind(flight_id).Step();
  return statement.Int(0);
}

}  // namespace freelsd
