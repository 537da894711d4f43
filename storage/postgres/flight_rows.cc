#include "storage/postgres/flight_rows.h"

#include <limits>

namespace freelsd {

const char* const kFlightColumns =
    "id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
    "num_rejected_frames, has_failed, ground_altitude_m, has_retired_images";

FlightRow FlightRowOf(const PostgresRow& row) {
  FlightRow flight;
  flight.id = row.Text(0);
  flight.name = row.Text(1);
  flight.request_json = row.Text(2);
  flight.rig_json = row.Text(3);
  flight.warnings_json = row.Text(4);
  flight.stages_json = row.Text(5);
  flight.created_at_us = row.Int(6);
  flight.num_rejected_frames = row.Int(7);
  flight.has_failed = row.Bool(8);
  flight.ground_altitude_m = row.OptionalReal(9);
  flight.has_retired_images = row.Bool(10);
  return flight;
}

std::vector<std::string> ImagesOfFrames(PostgresConnection& writer, const std::string& flight_id) {
  return writer
      .Run(
          "SELECT DISTINCT stored_image FROM frames WHERE flight_id = $1 "
          "AND stored_image IS NOT NULL",
          flight_id)
      .Texts();
}

std::optional<std::vector<std::string>> DeleteFlightRow(PostgresConnection& writer,
                                                        const std::string& flight_id) {
  std::vector<std::string> images = ImagesOfFrames(writer, flight_id);
  if (writer.Run("DELETE FROM flights WHERE id = $1", flight_id).NumChanges() == 0) {
    return std::nullopt;
  }
  return images;
}

bool LockFlight(PostgresConnection& writer, const std::string& flight_id) {
  return !writer.Run("SELECT 1 FROM flights WHERE id = $1 FOR NO KEY UPDATE", flight_id).empty();
}

std::vector<std::string> LockFreeFlights(PostgresConnection& writer,
                                         const std::vector<std::string>& flight_ids) {
  return writer
      .Run("SELECT id FROM flights WHERE id = ANY($1) ORDER BY id FOR NO KEY UPDATE SKIP LOCKED",
           flight_ids)
      .Texts();
}

bool ChangeFlight(PostgresConnection& writer,
                  const std::string& flight_id,
                  const FlightChange& change) {
  if (!LockFlight(writer, flight_id)) return false;
  const PostgresRows rows = writer.Run(
      std::string("SELECT ") + kFlightColumns + " FROM flights WHERE id = $1", flight_id);
  FlightRow flight = FlightRowOf(rows[0]);
  change(flight);
  writer.Run(
      "UPDATE flights SET name = $2, rig_json = $3, warnings_json = $4, stages_json = $5, "
      "num_rejected_frames = $6, has_failed = $7, ground_altitude_m = $8, "
      "has_retired_images = $9 WHERE id = $1",
      flight_id,
      flight.name,
      flight.rig_json,
      flight.warnings_json,
      flight.stages_json,
      flight.num_rejected_frames,
      flight.has_failed,
      flight.ground_altitude_m,
      flight.has_retired_images);
  return true;
}

std::map<std::string, int64_t> NextArrivalsOf(PostgresConnection& writer,
                                              const std::vector<std::string>& flight_ids) {
  // One search of an index for each part: a flight may have a million samples.
  const PostgresRows rows = writer.Run(
      "SELECT flight, greatest("
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 0), "
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 1), "
      "(SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = flight AND kind = 2), "
      "(SELECT arrived_at_us FROM frames WHERE flight_id = flight ORDER BY sequence DESC LIMIT 1)) "
      "FROM unnest($1) AS flight",
      flight_ids);
  std::map<std::string, int64_t> next;
  for (int i = 0; i < rows.size(); ++i) {
    const std::optional<int64_t> last = rows[i].OptionalInt(1);
    next[rows[i].Text(0)] = last ? *last + 1 : std::numeric_limits<int64_t>::min();
  }
  return next;
}

}  // namespace freelsd
