#include "storage/sqlite/arrivals.h"

#include <limits>

namespace freelsd {

int64_t NextArrival(const Connection& connection, const std::string& flight_id) {
  // One search of an index for each part: a flight may have a million samples.
  Statement statement = connection.Prepare(
      "SELECT max(last) FROM ("
      "SELECT max(arrived_at_us) AS last FROM telemetry WHERE flight_id = ?1 AND kind = 0 "
      "UNION ALL SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = ?1 AND kind = 1 "
      "UNION ALL SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = ?1 AND kind = 2 "
      "UNION ALL SELECT arrived_at_us FROM (SELECT arrived_at_us FROM frames "
      "WHERE flight_id = ?1 ORDER BY sequence DESC LIMIT 1))");
  statement.Bind(flight_id).Step();
  const std::optional<int64_t> last = statement.OptionalInt(0);
  return last ? *last + 1 : std::numeric_limits<int64_t>::min();
}

}  // namespace freelsd
