#include "server/jobs/watching/stored_strip.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "server/recall/recall.h"

namespace freelsd {
namespace {

// Finest pixels first: the first level that is coarser would lose detail.
int LevelFor(const PhotoLattice& photo, double pixel_m) {
  int level = 0;
  while (level + 1 < photo.num_levels && std::ldexp(photo.pixel_size_m, level + 1) <= pixel_m) {
    ++level;
  }
  return level;
}

Polygon DiscAt(const Eigen::Vector2d& place, double radius_m) {
  constexpr int kNumCorners = 16;
  Polygon disc;
  for (int i = 0; i < kNumCorners; ++i) {
    disc.push_back(place + radius_m * DirectionOf(2.0 * std::numbers::pi * i / kNumCorners));
  }
  return disc;
}

GeoPoint PointOf(const nlohmann::json& position) {
  return {position.at(1), position.at(0), position.size() > 2 ? position.at(2).get<double>() : 0.0};
}

// Corners of the planned roll; empty without one.
std::vector<GeoPoint> RollOf(const SiteRow& site) {
  std::vector<GeoPoint> corners;
  if (site.approach_json.empty()) return corners;
  const nlohmann::json approach = nlohmann::json::parse(site.approach_json);
  for (const nlohmann::json& feature : approach.at("features")) {
    if (feature.at("properties").value("kind", "") != "ground_roll") continue;
    for (const nlohmann::json& position : feature.at("geometry").at("coordinates").at(0)) {
      corners.push_back(PointOf(position));
    }
  }
  // A ring repeats its first corner.
  if (!corners.empty()) corners.pop_back();
  return corners;
}

// One picture of all windows that lie in the box.
void Compose(const std::vector<PhotoWindow>& windows, const WorldBox& box, StripPicture& strip) {
  const double pixel_m = windows.front().grid.cell_size_m;
  strip.grid = GridAround(box.min_in_world, box.max_in_world, pixel_m);
  strip.picture = cv::Mat4b(strip.grid.num_rows, strip.grid.num_cols, cv::Vec4b(0, 0, 0, 0));
  const cv::Rect all(0, 0, strip.grid.num_cols, strip.grid.num_rows);
  for (const PhotoWindow& window : windows) {
    const Eigen::Vector2d offset =
        (window.grid.north_west_in_world - strip.grid.north_west_in_world) / pixel_m;
    const cv::Rect placed(static_cast<int>(std::lround(offset.x())),
                          static_cast<int>(std::lround(-offset.y())),
                          window.pixels.cols,
                          window.pixels.rows);
    const cv::Rect inside = placed & all;
    if (!inside.empty()) window.pixels(inside - placed.tl()).copyTo(strip.picture(inside));
  }
}

// Of the cells of the roll; NaN where none is known.
double HighestGround(const StripPicture& strip) {
  float highest = -std::numeric_limits<float>::infinity();
  for (const cv::Point& cell : strip.ground_grid.CellsIn(strip.outlines.front())) {
    const float height = strip.elevation(cell);
    if (height > highest) highest = height;
  }
  return std::isfinite(highest) ? highest : std::nan("");
}

}  // namespace

std::optional<StoredStrip> StoredStripOf(const Storage& storage,
                                         FlightMaps& maps,
                                         const SiteRow& site,
                                         const WatchOptions& options) {
  const auto map = maps.Find(storage, site.map_id);
  if (!map || !map->head.photo) return std::nullopt;
  StoredStrip stored;
  stored.corners = RollOf(site);
  if (stored.corners.size() < 3) return std::nullopt;
  stored.local_frame = map->local_frame;
  stored.altitude_datum = map->row.altitude_datum;
  stored.flight_id = map->row.flight_id;
  const auto in_world = [&](const GeoPoint& point) -> Eigen::Vector2d {
    return map->local_frame.WorldFromGeo(point).head<2>();
  };
  Polygon roll;
  for (const GeoPoint& corner : stored.corners) roll.push_back(in_world(corner));
  const Replan replan = ParseReplan(site.replan_json);
  const GeoPoint touchdown{
      site.latitude_deg, site.longitude_deg, stored.corners.front().altitude_m};
  StripPicture& picture = stored.picture;
  picture.outlines = {roll,
                      DiscAt(in_world(touchdown), replan.flight.aircraft.touchdown_uncertainty_m)};
  WorldBox box{roll.front(), roll.front()};
  for (const Polygon& outline : picture.outlines) {
    for (const Eigen::Vector2d& corner : outline) {
      box.min_in_world = box.min_in_world.cwiseMin(corner);
      box.max_in_world = box.max_in_world.cwiseMax(corner);
    }
  }
  const double reach_m = options.context_m + options.max_offset_m;
  const Polygon corners{box.min_in_world, box.max_in_world};
  box.min_in_world.array() -= reach_m;
  box.max_in_world.array() += reach_m;
  const int level = LevelFor(*map->head.photo, options.min_pixel_m);
  const std::vector<PhotoWindow> windows = maps.ReadPhoto(storage, *map, level, box);
  if (windows.empty()) return std::nullopt;
  Compose(windows, box, picture);
  const Grid& grid = map->head.grid;
  const cv::Rect cells =
      grid.CellsAround(corners, reach_m) & cv::Rect(0, 0, grid.num_cols, grid.num_rows);
  if (cells.empty()) return std::nullopt;
  picture.ground_grid = grid.Part(cells);
  const MapRasters ground = maps.Read(storage, *map, 0, picture.ground_grid, TileLayers::kPlanning);
  picture.elevation = ground.site_map.map.elevation;
  picture.upper = ground.site_map.map.upper;
  const Eigen::Vector2d middle = in_world(touchdown);
  const double highest = HighestGround(picture);
  if (!std::isfinite(highest)) return std::nullopt;
  stored.highest_m = map->local_frame.GeoFromWorld({middle.x(), middle.y(), highest}).altitude_m;
  return stored;
}

}  // namespace freelsd
