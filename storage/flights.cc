#include <mutex>

#include "storage/flight_rows.h"
#include "storage/state.h"
#include "storage/storage.h"

namespace freelsd {
namespace {

constexpr char kSelectFlight[] =
    "SELECT id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
    "num_rejected_frames, has_failed, ground_altitude_m FROM flights WHERE id = ?1";
constexpr char kSelectFlights[] =
    "SELECT id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
    "num_rejected_frames, has_failed, ground_altitude_m FROM flights ORDER BY created_at_us DESC, "
    "id";

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
  return flight;
}

std::optional<FlightRow> Find(const Connection& connection, const std::string& flight_id) {
  Statement statement = connection.Prepare(kSelectFlight);
  if (!statement.Bind(flight_id).Step()) return std::nullopt;
  return RowOf(statement);
}

// Images that only this flight's frames need.
std::vector<std::string> OwnImages(const Connection& writer, const std::string& flight_id) {
  std::vector<std::string> images;
  Statement statement = writer.Prepare(
      "SELECT DISTINCT sha256 FROM frames AS mine WHERE flight_id = ?1 AND NOT EXISTS ("
      "SELECT 1 FROM frames WHERE sha256 = mine.sha256 AND flight_id <> ?1)");
  statement.Bind(flight_id);
  while (statement.Step()) images.push_back(statement.Text(0));
  return images;
}

}  // namespace

bool ChangeFlightRow(const Connection& writer,
                     const std::string& flight_id,
                     const Storage::FlightChange& change) {
  std::optional<FlightRow> flight = Find(writer, flight_id);
  if (!flight) return false;
  change(*flight);
  writer
      .Prepare(
          "UPDATE flights SET name = ?2, rig_json = ?3, warnings_json = ?4, stages_json = ?5, "
          "num_rejected_frames = ?6, has_failed = ?7, ground_altitude_m = ?8 WHERE id = ?1")
      .Bind(flight_id,
            flight->name,
            flight->rig_json,
            flight->warnings_json,
            flight->stages_json,
            flight->num_rejected_frames,
            static_cast<int>(flight->has_failed),
            flight->ground_altitude_m)
      .Run();
  return true;
}

void Storage::InsertFlight(const FlightRow& flight) {
  const std::lock_guard lock(state_->write_mutex);
  state_->writer.Prepare("INSERT INTO flights VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)")
      .Bind(flight.id,
            flight.name,
            flight.request_json,
            flight.rig_json,
            flight.warnings_json,
            flight.stages_json,
            flight.created_at_us,
            flight.num_rejected_frames,
            static_cast<int>(flight.has_failed),
            flight.ground_altitude_m)
      .Run();
}

bool Storage::ChangeFlight(const std::string& flight_id, const FlightChange& change) {
  const std::lock_guard lock(state_->write_mutex);
  Transaction transaction(state_->writer);
  const bool is_there = ChangeFlightRow(state_->writer, flight_id, change);
  transaction.Commit();
  return is_there;
}

std::optional<FlightRow> Storage::FindFlight(const std::string& flight_id) const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare(kSelectFlight);
  if (!statement.Bind(flight_id).Step()) return std::nullopt;
  return RowOf(statement);
}

std::vector<FlightRow> Storage::ListFlights() const {
  const Reader reader(state_->readers);
  Statement statement = reader->Prepare(kSelectFlights);
  std::vector<FlightRow> flights;
  while (statement.Step()) flights.push_back(RowOf(statement));
  return flights;
}

bool Storage::DeleteFlight(const std::string& flight_id, bool forget_sites) {
  const std::lock_guard lock(state_->write_mutex);
  Transaction transaction(state_->writer);
  const std::vector<std::string> images = OwnImages(state_->writer, flight_id);
  state_->writer.Prepare("DELETE FROM flights WHERE id = ?1").Bind(flight_id).Run();
  const bool was_there = state_->writer.NumChanges() > 0;
  if (was_there && forget_sites) {
    state_->writer.Prepare("DELETE FROM sites WHERE flight_id = ?1").Bind(flight_id).Run();
  }
  transaction.Commit();
  for (const std::string& sha256 : images) state_->images.Remove(sha256);
  return was_there;
}

}  // namespace freelsd
