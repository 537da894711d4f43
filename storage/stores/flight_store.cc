#include <limits>

#include "storage/stores/stores.h"

namespace freelsd {
namespace {

constexpr int kNumFlightColumns = 11;
const std::string kFlightColumns =
    "id, name, request_json, rig_json, warnings_json, stages_json, created_at_us, "
    "num_rejected_frames, has_failed, ground_altitude_m, has_retired_images";

FlightRow FlightRowOf(const Row& row) {
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

std::string SelectFlights(const std::string& which) {
  return "SELECT " + kFlightColumns + " FROM flights " + which;
}

// Each count comes from an index. Sequence numbers run from 1 without a gap.
std::string SelectSummaries(const Dialect& dialect, const std::string& which) {
  return "SELECT " + kFlightColumns +
         ", (SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = flights.id), "
         "(SELECT count(*) FROM frames WHERE flight_id = flights.id AND state = 0), "
         "(SELECT count(*) FROM regions WHERE flight_id = flights.id), "
         "(SELECT count(*) FROM sites WHERE flight_id = flights.id), "
         "EXISTS (SELECT 1 FROM jobs WHERE flight_id = flights.id AND state < 2), " +
         dialect.flight_number + " FROM flights " + which;
}

FlightSummary SummaryOf(const Row& row) {
  FlightSummary summary;
  summary.flight = FlightRowOf(row);
  summary.num_frames = row.Int(kNumFlightColumns);
  summary.num_queued_frames = row.Int(kNumFlightColumns + 1);
  summary.num_regions = row.Int(kNumFlightColumns + 2);
  summary.num_sites = row.Int(kNumFlightColumns + 3);
  summary.has_unfinished_job = row.Bool(kNumFlightColumns + 4);
  summary.number = row.Int(kNumFlightColumns + 5);
  return summary;
}

}  // namespace

bool LockFlight(Database& writer, const std::string& flight_id) {
  return writer.Has("SELECT 1 FROM flights WHERE id = $1 FOR NO KEY UPDATE", flight_id);
}

bool ChangeFlightRow(Database& writer, const std::string& flight_id, const FlightChange& change) {
  std::optional<FlightRow> flight =
      writer.First(FlightRowOf, SelectFlights("WHERE id = $1 FOR NO KEY UPDATE"), flight_id);
  if (!flight) return false;
  change(*flight);
  writer.Change(
      "UPDATE flights SET name = $2, rig_json = $3, warnings_json = $4, stages_json = $5, "
      "num_rejected_frames = $6, has_failed = $7, ground_altitude_m = $8, "
      "has_retired_images = $9 WHERE id = $1",
      flight_id,
      flight->name,
      flight->rig_json,
      flight->warnings_json,
      flight->stages_json,
      flight->num_rejected_frames,
      flight->has_failed,
      flight->ground_altitude_m,
      flight->has_retired_images);
  return true;
}

bool DeleteFlightRow(Writer& writer, const Dialect& dialect, const std::string& flight_id) {
  const std::string& image = dialect.frame_image;
  const std::vector<std::string> images =
      writer->Texts("SELECT DISTINCT " + image + " FROM frames WHERE flight_id = $1 AND " + image +
                        " IS NOT NULL",
                    flight_id);
  if (writer->Change("DELETE FROM flights WHERE id = $1", flight_id) == 0) return false;
  writer.unused_images.insert(writer.unused_images.end(), images.begin(), images.end());
  return true;
}

int64_t NextArrival(Database& writer, const std::string& flight_id) {
  // One search of an index for each part: a flight may have a million samples.
  const auto last = writer.First(
      [](const Row& row) { return row.OptionalInt(0); },
      "SELECT max(last) FROM ("
      "SELECT max(arrived_at_us) AS last FROM telemetry WHERE flight_id = $1 AND kind = 0 "
      "UNION ALL SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = $1 AND kind = 1 "
      "UNION ALL SELECT max(arrived_at_us) FROM telemetry WHERE flight_id = $1 AND kind = 2 "
      "UNION ALL SELECT arrived_at_us FROM (SELECT arrived_at_us FROM frames "
      "WHERE flight_id = $1 ORDER BY sequence DESC LIMIT 1) AS frame) AS part",
      flight_id);
  return *last ? **last + 1 : std::numeric_limits<int64_t>::min();
}

void SqlFlightStore::Insert(const FlightRow& flight) {
  access_.Write([&](Writer& writer) {
    writer->Change("INSERT INTO flights (" + kFlightColumns +
                       ") VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
                   flight.id,
                   flight.name,
                   flight.request_json,
                   flight.rig_json,
                   flight.warnings_json,
                   flight.stages_json,
                   flight.created_at_us,
                   flight.num_rejected_frames,
                   flight.has_failed,
                   flight.ground_altitude_m,
                   flight.has_retired_images);
  });
}

bool SqlFlightStore::Change(const std::string& flight_id, const FlightChange& change) {
  return access_.Write([&](Writer& writer) { return ChangeFlightRow(*writer, flight_id, change); });
}

std::optional<FlightRow> SqlFlightStore::Find(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.First(FlightRowOf, SelectFlights("WHERE id = $1"), flight_id);
  });
}

std::optional<FlightSummary> SqlFlightStore::FindSummary(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.First(
        SummaryOf, SelectSummaries(access_.dialect(), "WHERE id = $1"), flight_id);
  });
}

std::vector<FlightRow> SqlFlightStore::List() const {
  return access_.Read([](Database& database) {
    return database.Each(FlightRowOf, SelectFlights("ORDER BY created_at_us DESC, id"));
  });
}

FlightPage SqlFlightStore::ListPage(size_t limit, std::optional<int64_t> before_number) const {
  const std::string& number = access_.dialect().flight_number;
  FlightPage page;
  page.flights = access_.Read([&](Database& database) {
    return database.Each(
        SummaryOf,
        SelectSummaries(access_.dialect(),
                        "WHERE " + number + " < $1 ORDER BY " + number + " DESC LIMIT $2"),
        before_number.value_or(std::numeric_limits<int64_t>::max()),
        static_cast<int64_t>(limit) + 1);
  });
  page.has_more = page.flights.size() > limit;
  if (page.has_more) page.flights.pop_back();
  return page;
}

int64_t SqlFlightStore::Count() const {
  return access_.Read(
      [](Database& database) { return database.Int("SELECT count(*) FROM flights"); });
}

std::vector<std::string> SqlFlightStore::ListWithQueuedFrames() const {
  return access_.Read([](Database& database) {
    return database.Texts(
        "SELECT id FROM flights WHERE EXISTS (SELECT 1 FROM frames WHERE flight_id = flights.id "
        "AND state = 0) ORDER BY created_at_us, id");
  });
}

bool SqlFlightStore::RetireImages(const std::string& flight_id) {
  const Dialect& dialect = access_.dialect();
  return access_.Write([&](Writer& writer) {
    LockFlight(*writer, flight_id);
    if (writer->Has(dialect.flight_in_use, flight_id)) return false;
    ChangeFlightRow(
        *writer, flight_id, [](FlightRow& flight) { flight.has_retired_images = true; });
    writer.retired_images = writer->Texts(dialect.retired_images, flight_id);
    if (!dialect.retire_images.empty()) writer->Change(dialect.retire_images, flight_id);
    return true;
  });
}

bool SqlFlightStore::Delete(const std::string& flight_id) {
  return access_.Write(
      [&](Writer& writer) { return DeleteFlightRow(writer, access_.dialect(), flight_id); });
}

void SqlFlightStore::ReplaceRegions(const std::string& flight_id,
                                    const std::vector<RegionRow>& regions) {
  access_.Write([&](Writer& writer) {
    LockFlight(*writer, flight_id);
    writer->Change("DELETE FROM regions WHERE flight_id = $1", flight_id);
    int64_t rank = 0;
    for (const RegionRow& region : regions) {
      writer->Change(
          "INSERT INTO regions (flight_id, id, rank, feature_json, history_json) "
          "VALUES ($1, $2, $3, $4, $5)",
          flight_id,
          region.id,
          rank++,
          region.feature_json,
          region.history_json);
    }
  });
}

std::vector<RegionRow> SqlFlightStore::ListRegions(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.Each(
        [](const Row& row) {
          return RegionRow{row.Int(0), row.Text(1), row.Text(2)};
        },
        "SELECT id, feature_json, history_json FROM regions WHERE flight_id = $1 ORDER BY rank",
        flight_id);
  });
}

int64_t SqlFlightStore::CountRegions(const std::string& flight_id) const {
  return access_.Read([&](Database& database) {
    return database.Int("SELECT count(*) FROM regions WHERE flight_id = $1", flight_id);
  });
}

}  // namespace freelsd
