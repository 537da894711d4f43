#include "server/recall/terrain_margin.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <vector>

namespace freelsd {
namespace {

// Maps are searched in one box per piece of the way: a box around a whole diagonal has too many.
constexpr double kMinPieceDeg = 0.004;
constexpr int kMaxNumPieces = 16;

// Stored maps that the straight way may cross, without duplicates.
SharedRows<MapRow> MapsOnTheWay(const StoredSites& stored,
                                const GeoPoint& begin,
                                const GeoPoint& end) {
  const double dlat_deg = end.latitude_deg - begin.latitude_deg;
  const double dlon_deg = std::remainder(end.longitude_deg - begin.longitude_deg, 360.0);
  const double length_deg = std::max(std::abs(dlat_deg), std::abs(dlon_deg));
  const int num_pieces =
      std::clamp(static_cast<int>(std::ceil(length_deg / kMinPieceDeg)), 1, kMaxNumPieces);
  SharedRows<MapRow> rows;
  std::set<std::string_view> ids;
  for (int i = 0; i < num_pieces; ++i) {
    const double from = static_cast<double>(i) / num_pieces;
    const double to = static_cast<double>(i + 1) / num_pieces;
    const auto [south_deg, north_deg] =
        std::minmax({begin.latitude_deg + from * dlat_deg, begin.latitude_deg + to * dlat_deg});
    const auto [west_deg, east_deg] =
        std::minmax({begin.longitude_deg + from * dlon_deg, begin.longitude_deg + to * dlon_deg});
    const BoundingBox box{
        std::remainder(west_deg, 360.0), south_deg, std::remainder(east_deg, 360.0), north_deg};
    for (auto& row : stored.storage.sites.ListMaps(box)) {
      if (ids.insert(row->site_id).second) rows.push_back(std::move(row));
    }
  }
  return rows;
}

// The map's altitudes, at its middle.
AltitudeReference ReferenceOf(const MapRow& row, const KeptTerrain& terrain) {
  const Grid& grid = terrain.grid;
  const Eigen::Vector2d middle =
      grid.north_west_in_world +
      0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
  const GeoPoint place = LocalFrame(terrain.origin).GeoFromWorld({middle.x(), middle.y(), 0.0});
  return {row.altitude_datum, place.latitude_deg, place.longitude_deg, row.flight_id};
}

}  // namespace

std::optional<TerrainMargin> TerrainMarginOf(const StoredSites& stored,
                                             const EmergencyRequest& request,
                                             const GeoPoint& end) {
  std::optional<TerrainMargin> least;
  for (const auto& row : MapsOnTheWay(stored, request.place, end)) {
    const auto terrain = stored.maps.TerrainOf(stored.storage, row->site_id, row->updated_at_us);
    if (!terrain) continue;
    const LocalFrame local_frame(terrain->origin);
    const auto height = LeastHeightOver(terrain->grid,
                                        terrain->upper,
                                        local_frame.WorldFromGeo(request.place),
                                        local_frame.WorldFromGeo(end));
    if (!height) continue;
    const DatumDifference datum =
        DatumDifferenceOf(ReferenceOf(request), ReferenceOf(*row, *terrain));
    const double margin_m = *height - GlideOptions{}.terrain_clearance_m - datum.subtracted_m;
    if (!least || margin_m < least->margin_m) least = TerrainMargin{margin_m, datum};
  }
  return least;
}

}  // namespace freelsd
