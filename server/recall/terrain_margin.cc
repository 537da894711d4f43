#include "server/recall/terrain_margin.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <vector>

namespace freelsd {
namespace {

// Maps are searched in one box per piece of the path. A single box around a long diagonal path
// would contain too many maps.
constexpr double kMinPieceDeg = 0.004;
constexpr int kMaxNumPieces = 16;

double SpanDeg(const GeoPoint& a, const GeoPoint& b) {
  const double dlon_deg = std::remainder(b.longitude_deg - a.longitude_deg, 360.0);
  return std::max(std::abs(b.latitude_deg - a.latitude_deg), std::abs(dlon_deg));
}

// Longitude may leave [-180, 180] in between; Wrapped puts it back.
void Extend(BoundingBox& box, const GeoPoint& point) {
  const double longitude_deg =
      box.west_deg + std::remainder(point.longitude_deg - box.west_deg, 360.0);
  box = {std::min(box.west_deg, longitude_deg),
         std::min(box.south_deg, point.latitude_deg),
         std::max(box.east_deg, longitude_deg),
         std::max(box.north_deg, point.latitude_deg)};
}

BoundingBox BoxOf(const GeoPoint& point) {
  return {point.longitude_deg, point.latitude_deg, point.longitude_deg, point.latitude_deg};
}

BoundingBox Wrapped(const BoundingBox& box) {
  return {std::remainder(box.west_deg, 360.0),
          box.south_deg,
          std::remainder(box.east_deg, 360.0),
          box.north_deg};
}

GeoPoint Between(const GeoPoint& a, const GeoPoint& b, double ratio) {
  const double dlon_deg = std::remainder(b.longitude_deg - a.longitude_deg, 360.0);
  return {a.latitude_deg + ratio * (b.latitude_deg - a.latitude_deg),
          a.longitude_deg + ratio * dlon_deg,
          a.altitude_m + ratio * (b.altitude_m - a.altitude_m)};
}

// Boxes that together enclose the path. Short legs share one box, long ones have several.
std::vector<BoundingBox> BoxesAlong(const std::vector<GeoPoint>& path) {
  std::vector<BoundingBox> boxes{BoxOf(path.front())};
  for (size_t i = 1; i < path.size(); ++i) {
    const double span_deg = SpanDeg(path[i - 1], path[i]);
    const int num_pieces =
        std::clamp(static_cast<int>(std::ceil(span_deg / kMinPieceDeg)), 1, kMaxNumPieces);
    for (int piece = 0; piece < num_pieces; ++piece) {
      const BoundingBox& last = boxes.back();
      const double size_deg =
          std::max(last.east_deg - last.west_deg, last.north_deg - last.south_deg);
      const double step_deg = span_deg / num_pieces;
      if (size_deg + step_deg > kMinPieceDeg) {
        boxes.push_back(
            BoxOf(Between(path[i - 1], path[i], static_cast<double>(piece) / num_pieces)));
      }
      Extend(boxes.back(),
             Between(path[i - 1], path[i], static_cast<double>(piece + 1) / num_pieces));
    }
  }
  for (BoundingBox& box : boxes) box = Wrapped(box);
  return boxes;
}

// Stored maps that the path may cross, without duplicates.
SharedRows<MapRow> MapsAlong(const StoredSites& stored, const std::vector<GeoPoint>& path) {
  SharedRows<MapRow> rows;
  std::set<std::string_view> ids;
  for (const BoundingBox& box : BoxesAlong(path)) {
    for (auto& row : stored.storage.sites.ListMaps(box)) {
      if (ids.insert(row->id).second) rows.push_back(std::move(row));
    }
  }
  return rows;
}

// Least height of the path above one map; nothing if no seen cell of it lies below the path.
std::optional<double> LeastHeightAlong(const std::vector<GeoPoint>& path,
                                       const KeptTerrain& terrain) {
  const LocalFrame local_frame(terrain.origin);
  std::optional<double> least;
  Eigen::Vector3d begin = local_frame.WorldFromGeo(path.front());
  for (size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector3d end = local_frame.WorldFromGeo(path[i]);
    const auto height = LeastHeightOver(terrain.grid, terrain.upper, begin, end);
    if (height && (!least || *height < *least)) least = height;
    begin = end;
  }
  return least;
}

// World z of the seen blocks within about 20 m; nothing if the map has not seen the place.
std::optional<HeightRange> BlocksAround(const KeptTerrain& terrain, const Eigen::Vector2d& place) {
  constexpr double kAroundM = 20.0;
  const auto middle = terrain.grid.CellAt(place);
  if (!middle || std::isnan(terrain.upper(*middle))) return std::nullopt;
  const int reach = std::max(1, static_cast<int>(std::lround(kAroundM / terrain.grid.cell_size_m)));
  const cv::Rect around(middle->x - reach, middle->y - reach, 2 * reach + 1, 2 * reach + 1);
  return HeightRangeOf(terrain.upper(around & cv::Rect({}, terrain.upper.size())));
}

}  // namespace

AltitudeReference ReferenceOf(const MapRow& row, const KeptTerrain& terrain) {
  const Grid& grid = terrain.grid;
  const Eigen::Vector2d middle =
      grid.north_west_in_world +
      0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
  const GeoPoint place = LocalFrame(terrain.origin).GeoFromWorld({middle.x(), middle.y(), 0.0});
  return {row.altitude_datum, place.latitude_deg, place.longitude_deg, row.flight_id};
}

std::shared_ptr<const KeptTerrain> TerrainBelow(const StoredSites& stored, const RecallRow& site) {
  return stored.maps.TerrainOf(stored.storage, site.map_id);
}

std::vector<MapBelow> MapsBelow(const StoredSites& stored,
                                const EmergencyRequest& request,
                                const std::vector<GeoPoint>& path) {
  std::vector<MapBelow> maps;
  for (const auto& row : MapsAlong(stored, path)) {
    const auto terrain = stored.maps.TerrainOf(stored.storage, row->id);
    if (!terrain || !terrain->CountsFor(request.flight_id)) continue;
    maps.push_back({terrain, DatumDifferenceOf(ReferenceOf(request), ReferenceOf(*row, *terrain))});
  }
  return maps;
}

std::optional<HeightRange> GroundAltitudesAt(const std::vector<MapBelow>& maps,
                                             const GeoPoint& place) {
  std::optional<HeightRange> found;
  for (const auto& [terrain, datum] : maps) {
    const LocalFrame local_frame(terrain->origin);
    const Eigen::Vector3d place_in_world = local_frame.WorldFromGeo(place);
    const auto blocks = BlocksAround(*terrain, place_in_world.head<2>());
    if (!blocks) continue;
    const double altitude_of_zero_m = place.altitude_m - place_in_world.z() + datum.subtracted_m;
    const double lowest_m = altitude_of_zero_m + blocks->lowest_m;
    const double highest_m = altitude_of_zero_m + blocks->highest_m;
    found = found ? HeightRange{std::min(found->lowest_m, lowest_m),
                                std::max(found->highest_m, highest_m)}
                  : HeightRange{lowest_m, highest_m};
  }
  return found;
}

std::optional<TerrainMargin> TerrainMarginOf(const StoredSites& stored,
                                             const EmergencyRequest& request,
                                             const std::vector<GeoPoint>& path) {
  std::optional<TerrainMargin> least;
  for (const auto& [terrain, datum] : MapsBelow(stored, request, path)) {
    const auto height = LeastHeightAlong(path, *terrain);
    if (!height) continue;
    const double margin_m = *height - datum.subtracted_m;
    if (!least || margin_m < least->margin_m) least = TerrainMargin{margin_m, datum};
  }
  return least;
}

bool IsSeenBelow(const KeptTerrain& terrain,
                 const Eigen::Vector3d& begin_in_world,
                 const Eigen::Vector3d& end_in_world) {
  const double length = (end_in_world - begin_in_world).head<2>().norm();
  const int num_steps =
      std::max(1, static_cast<int>(std::ceil(length / (0.5 * terrain.grid.cell_size_m))));
  for (int i = 0; i <= num_steps; ++i) {
    const Eigen::Vector3d point =
        begin_in_world + static_cast<double>(i) / num_steps * (end_in_world - begin_in_world);
    const auto cell = terrain.grid.CellAt(point.head<2>());
    if (!cell || terrain.is_seen(*cell) == 0) return false;
  }
  return true;
}

}  // namespace freelsd
