#include <algorithm>
#include <limits>

#include "storage/postgres/flight_rows.h"
#include "storage/postgres/images.h"
#include "storage/postgres/state.h"
#include "storage/postgres/stores.h"

namespace freelsd {
namespace {

constexpr int kNumFlightColumns = 11;

// Each count comes from an index. Sequence numbers run from 1 without a gap.
constexpr char kSelectCounts[] =
    ", (SELECT coalesce(max(sequence), 0) FROM frames WHERE flight_id = flights.id), "
    "(SELECT count(*) FROM frames WHERE flight_id = flights.id AND state = 0), "
    "(SELECT count(*) FROM regions WHERE flight_id = flights.id), "
    "(SELECT count(*) FROM sites WHERE flight_id = flights.id), "
    "EXISTS (SELECT 1 FROM jobs WHERE flight_id = flights.id AND state < 2), "
    "number FROM flights ";

std::string SelectFlights(const std::string& which) {
  return std::string("SELECT ") + kFlightColumns + " FROM flights " + which;
}

std::string SelectSummaries(const std::string& which) {
  return std::string("SELECT ") + kFlightColumns + kSelectCounts + which;
}

FlightSummary SummaryOf(const PostgresRow& row) {
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

void PostgresFlightStore::Insert(const FlightRow& flight) {
  PostgresWrite writer(state_);
  writer->Run(std::string("INSERT INTO flights (") + kFlightColumns +
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
  writer.Commit();
}

bool PostgresFlightStore::Change(const std::string& flight_id, const FlightChange& change) {
  PostgresWrite writer(state_);
  const bool is_there = ChangeFlight(*writer, flight_id, change);
  writer.Commit();
  return is_there;
}

std::optional<FlightRow> PostgresFlightStore::Find(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<FlightRow> {
    const PostgresRows rows = connection.Run(SelectFlights("WHERE id = $1"), flight_id);
    if (rows.empty()) return std::nullopt;
    return FlightRowOf(rows[0]);
  });
}

std::optional<FlightSummary> PostgresFlightStore::FindSummary(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) -> std::optional<FlightSummary> {
    const PostgresRows rows = connection.Run(SelectSummaries("WHERE id = $1"), flight_id);
    if (rows.empty()) return std::nullopt;
    return SummaryOf(rows[0]);
  });
}

std::vector<FlightRow> PostgresFlightStore::List() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run(SelectFlights("ORDER BY created_at_us DESC, id")).Each(FlightRowOf);
  });
}

FlightPage PostgresFlightStore::ListPage(size_t limit, std::optional<int64_t> before_number) const {
  FlightPage page;
  page.flights = state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(SelectSummaries("WHERE number < $1 ORDER BY number DESC LIMIT $2"),
             before_number.value_or(std::numeric_limits<int64_t>::max()),
             static_cast<int64_t>(limit) + 1)
        .Each(SummaryOf);
  });
  page.has_more = page.flights.size() > limit;
  if (page.has_more) page.flights.pop_back();
  return page;
}

int64_t PostgresFlightStore::Count() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection.Run("SELECT count(*) FROM flights")[0].Int(0);
  });
}

std::vector<std::string> PostgresFlightStore::ListWithQueuedFrames() const {
  return state_.Read([](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT id FROM flights WHERE EXISTS (SELECT 1 FROM frames "
            "WHERE flight_id = flights.id AND state = 0) ORDER BY created_at_us, id")
        .Texts();
  });
}

bool PostgresFlightStore::RetireImages(const std::string& flight_id) {
  PostgresWrite writer(state_);
  LockFlight(*writer, flight_id);
  const PostgresRows in_use = writer->Run(
      "SELECT 1 FROM (SELECT (extract(epoch FROM clock_timestamp()) - 600) * 1000000 AS us) AS "
      "quiet "
      "WHERE EXISTS (SELECT 1 FROM frames WHERE flight_id = $1 AND "
      "(state = 0 OR ($2 AND arrived_at_us > us))) "
      "OR EXISTS (SELECT 1 FROM jobs WHERE flight_id = $1 AND state < 2) "
      "OR EXISTS (SELECT 1 FROM flights WHERE id = $1 AND $2 AND created_at_us > us)",
      flight_id,
      state_.options.is_shared);
  if (!in_use.empty()) return false;
  ChangeFlight(*writer, flight_id, [](FlightRow& flight) { flight.has_retired_images = true; });
  const std::vector<std::string> images = ImagesOfFrames(*writer, flight_id);
  writer->Run("UPDATE frames SET stored_image = NULL WHERE flight_id = $1", flight_id);
  writer.Commit();
  RemoveUnusedImages(state_, images);
  return true;
}

bool PostgresFlightStore::Delete(const std::string& flight_id) {
  std::optional<std::vector<std::string>> images;
  {
    PostgresWrite writer(state_);
    images = DeleteFlightRow(*writer, flight_id);
    if (!images) return false;
    writer.Commit();
  }
  RemoveUnusedImages(state_, *images);
  return true;
}

void PostgresFlightStore::ReplaceRegions(const std::string& flight_id,
                                         const std::vector<RegionRow>& regions) {
  PostgresWrite writer(state_);
  LockFlight(*writer, flight_id);
  writer->Run("DELETE FROM regions WHERE flight_id = $1", flight_id);
  int64_t rank = 0;
  for (const RegionRow& region : regions) {
    writer->Run(
        "INSERT INTO regions (flight_id, id, rank, feature_json, history_json) "
        "VALUES ($1, $2, $3, $4, $5)",
        flight_id,
        region.id,
        rank++,
        region.feature_json,
        region.history_json);
  }
  writer.Commit();
}

std::vector<RegionRow> PostgresFlightStore::ListRegions(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection
        .Run(
            "SELECT id, feature_json, history_json FROM regions WHERE flight_id = $1 ORDER BY rank",
            flight_id)
        .Each([](const PostgresRow& row) {
          return RegionRow{row.Int(0), row.Text(1), row.Text(2)};
        });
  });
}

int64_t PostgresFlightStore::CountRegions(const std::string& flight_id) const {
  return state_.Read([&](PostgresConnection& connection) {
    return connection.Run("SELECT count(*) FROM regions WHERE flight_id = $1", flight_id)[0].Int(0);
  });
}

}  // namespace freelsd
