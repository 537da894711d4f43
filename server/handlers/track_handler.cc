#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/handlers/paging.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

constexpr int64_t kMaxNumPositions = kLimits.answer.max_num_track_positions;

struct PassedPosition {
  std::optional<int64_t> timestamp_us;
  GeoPoint position;
};

// Positions of all frames that have one, by time; by sequence if any frame has no timestamp.
std::vector<GeoPoint> FramePositions(const Storage& storage, const std::string& flight_id) {
  std::vector<PassedPosition> passed;
  storage.frames.ForEachResolved(flight_id, [&passed](const std::string& resolved_json) {
    const FrameMeta meta = ParseStoredFrameMeta(resolved_json);
    if (meta.position) passed.push_back({meta.timestamp_us, *meta.position});
  });
  if (std::all_of(passed.begin(), passed.end(), [](const auto& one) { return one.timestamp_us; })) {
    std::stable_sort(passed.begin(), passed.end(), [](const auto& a, const auto& b) {
      return *a.timestamp_us < *b.timestamp_us;
    });
  }
  std::vector<GeoPoint> positions;
  positions.reserve(passed.size());
  for (const PassedPosition& one : passed) positions.push_back(one.position);
  return positions;
}

// The first position, the last one, and evenly spaced positions between them.
std::vector<GeoPoint> Thinned(const std::vector<GeoPoint>& positions) {
  if (static_cast<int64_t>(positions.size()) <= kMaxNumPositions) return positions;
  std::vector<GeoPoint> thinned;
  for (int64_t i = 0; i < kMaxNumPositions; ++i) {
    const int64_t place = i * (static_cast<int64_t>(positions.size()) - 1) / (kMaxNumPositions - 1);
    thinned.push_back(positions[static_cast<size_t>(place)]);
  }
  return thinned;
}

// One telemetry sample for each of kMaxNumPositions equal intervals of the flight's time.
std::vector<GeoPoint> TelemetryPositions(const Storage& storage, const std::string& flight_id) {
  const auto around = [&](int64_t timestamp_us) {
    return storage.telemetry.Around(flight_id, TelemetryKind::kPosition, timestamp_us);
  };
  const auto place = [](const TelemetryRow& row) {
    return GeoPoint{row.values[0], row.values[1], row.values[2]};
  };
  const std::optional<TelemetryRow> last = around(std::numeric_limits<int64_t>::max()).before;
  std::optional<TelemetryRow> next = around(std::numeric_limits<int64_t>::min()).after;
  std::vector<GeoPoint> positions;
  if (!last || !next) return positions;
  // Unsigned, because the difference of two arbitrary int64 times may overflow.
  const uint64_t duration_us =
      static_cast<uint64_t>(last->timestamp_us) - static_cast<uint64_t>(next->timestamp_us);
  const uint64_t step_us = duration_us / (kMaxNumPositions - 1) + 1;
  while (next && next->timestamp_us < last->timestamp_us) {
    positions.push_back(place(*next));
    const uint64_t left_us =
        static_cast<uint64_t>(last->timestamp_us) - static_cast<uint64_t>(next->timestamp_us);
    if (left_us <= step_us) break;
    next = around(next->timestamp_us + static_cast<int64_t>(step_us)).after;
  }
  positions.push_back(place(*last));
  return positions;
}

nlohmann::json FeatureOf(const std::vector<GeoPoint>& positions, const FlightRow& flight) {
  nlohmann::json coordinates = nlohmann::json::array();
  for (const GeoPoint& position : positions) {
    coordinates.push_back({position.longitude_deg, position.latitude_deg, position.altitude_m});
  }
  return {{"type", "Feature"},
          {"geometry", {{"type", "LineString"}, {"coordinates", std::move(coordinates)}}},
          {"properties",
           {{"flight_id", flight.id},
            {"num_positions", positions.size()},
            {"altitude_datum", AltitudeDatumOf(flight)}}}};
}

}  // namespace

void GetTrack(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight = ExistingFlight(service, call);
  std::vector<GeoPoint> positions = Thinned(FramePositions(service.storage, flight.id));
  if (positions.empty()) positions = TelemetryPositions(service.storage, flight.id);
  nlohmann::json features = nlohmann::json::array();
  // One position makes no line.
  if (positions.size() > 1) features.push_back(FeatureOf(positions, flight));
  AnswerGeoJson({{"type", "FeatureCollection"}, {"features", std::move(features)}}, response);
}

}  // namespace freelsd
