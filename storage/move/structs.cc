#include "storage/boxes.h"
#include "storage/move/move.h"

namespace freelsd {
namespace {

// Takes the values of a row one after the other.
class RowCursor {
 public:
  explicit RowCursor(const MovedRow& row) : row_(row) {}
  std::string Text() { return std::get<std::string>(row_.at(next_++)); }
  int64_t Int() { return std::get<int64_t>(row_.at(next_++)); }
  bool Bool() { return Int() != 0; }
  double Real() { return std::get<double>(row_.at(next_++)); }
  // 0 is NULL.
  std::optional<int64_t> OptionalInt() {
    const int64_t value = Int();
    return value == 0 ? std::nullopt : std::optional(value);
  }
  BoundingBox Box() {
    const double west_deg = Real(), south_deg = Real(), east_deg = Real(), north_deg = Real();
    return {west_deg, south_deg, east_deg, north_deg};
  }

 private:
  const MovedRow& row_;
  size_t next_ = 0;
};

Standing StandingIn(RowCursor& cursor) {
  Standing standing;
  if (std::string id = cursor.Text(); !id.empty()) standing.superseded_by = std::move(id);
  standing.superseded_by_map = cursor.Text();
  standing.superseded_at_us = cursor.Int();
  standing.superseded_reason = cursor.Text();
  standing.superseded_detail = cursor.Text();
  standing.confirmed_at_us = cursor.OptionalInt();
  standing.is_checked = cursor.Bool();
  return standing;
}

}  // namespace

SiteRow SiteIn(const MovedRow& row) {
  RowCursor cursor(row);
  SiteRow site;
  site.id = cursor.Text();
  site.flight_id = cursor.Text();
  site.region_id = cursor.Int();
  site.map_id = cursor.Text();
  site.latitude_deg = cursor.Real();
  site.longitude_deg = cursor.Real();
  site.feature_json = cursor.Text();
  site.approach_json = cursor.Text();
  site.replan_json = cursor.Text();
  site.updated_at_us = cursor.Int();
  site.seen_at_us = cursor.Int();
  site.seen_until_us = cursor.OptionalInt();
  static_cast<Standing&>(site) = StandingIn(cursor);
  const bool is_recallable = cursor.Bool();
  RecallData data;
  data.is_landable = cursor.Bool();
  data.altitude_m = cursor.Real();
  data.altitude_datum = cursor.Text();
  data.score = cursor.Real();
  data.aircraft_json = cursor.Text();
  site.map_datum = data.altitude_datum;
  if (is_recallable) site.recall = data;
  // SQLite counts longitudes on beyond 180 degrees.
  site.map_box = Rolled(cursor.Box());
  return site;
}

FlightMapRow MapIn(const MovedRow& row) {
  RowCursor cursor(row);
  FlightMapRow map;
  map.id = cursor.Text();
  map.flight_id = cursor.Text();
  map.head_json = cursor.Text();
  map.altitude_datum = cursor.Text();
  map.box = cursor.Box();
  map.updated_at_us = cursor.Int();
  map.seen_at_us = cursor.Int();
  map.seen_until_us = cursor.OptionalInt();
  return map;
}

ObstacleRow ObstacleIn(const MovedRow& row) {
  RowCursor cursor(row);
  ObstacleRow obstacle;
  obstacle.id = cursor.Text();
  obstacle.feature_json = cursor.Text();
  obstacle.box = cursor.Box();
  obstacle.expires_at_us = cursor.OptionalInt();
  obstacle.updated_at_us = cursor.Int();
  return obstacle;
}

}  // namespace freelsd
