#include "server/handlers/export/report_ground.h"

#include <algorithm>
#include <cmath>

namespace freelsd {
namespace {

// Longer sides of pictures. A page of many maps has smaller ones, or it would be too large to send.
constexpr int kLongestPx = 1600;
constexpr int kLeastLongestPx = 640;
constexpr int kCoveragePx = 600;
constexpr int kLandingPx = 800;

int LongestPx(size_t num_maps) {
  const double share = 1.0 / std::sqrt(static_cast<double>(num_maps));
  return std::max(kLeastLongestPx, static_cast<int>(kLongestPx * share));
}

// Part by part: a whole map may need more memory than a request is worth.
CellCounts CountsOf(const Service& service, const FlightMap& map) {
  constexpr int kPartCells = 4 * kTileCells;
  const Grid& grid = map.head.grid;
  CellCounts counts{static_cast<int64_t>(grid.num_rows) * grid.num_cols};
  for (int row = 0; row < grid.num_rows; row += kPartCells) {
    for (int col = 0; col < grid.num_cols; col += kPartCells) {
      const cv::Rect cells(col,
                           row,
                           std::min(kPartCells, grid.num_cols - col),
                           std::min(kPartCells, grid.num_rows - row));
      const MapRasters part = service.maps.flight_maps().Read(
          service.storage, map, 0, grid.Part(cells), TileLayers::kAll);
      const cv::Mat1b& hazard = part.site_map.layers.hazard;
      counts.num_free += std::count(hazard.begin(), hazard.end(), kFree);
      counts.num_seen += std::count_if(
          hazard.begin(), hazard.end(), [](uint8_t state) { return state != kUnseen; });
    }
  }
  return counts;
}

GroundPicture GroundOf(const FlightPicture& picture, const WorldBox& box, int longest_px) {
  GroundPicture ground{box, picture.PhotoOf(box, longest_px), {}};
  const Backdrop backdrop = ground.photo_jpeg.empty() ? Backdrop::kNone : Backdrop::kPhoto;
  ground.hazard_png = picture.HazardOf(box, longest_px, backdrop);
  return ground;
}

ReportedMap ReportedMapOf(const Service& service,
                          const FlightPicture& picture,
                          const FlightMap& map) {
  const MapHead& head = map.head;
  const WorldBox box = BoxOfGrid(head.grid);
  ReportedMap reported;
  reported.ground = GroundOf(picture, box, LongestPx(picture.maps().size()));
  reported.coverage_png = picture.LayerOf("coverage", box, kCoveragePx);
  if (!reported.coverage_png.empty()) reported.coverage_legend_png = picture.Legend("coverage");
  reported.cells = CountsOf(service, map);
  reported.quality = head.quality;
  reported.cell_size_m = head.grid.cell_size_m;
  reported.position_sd_m = head.position_sd_m;
  reported.tilt_sd_deg = head.tilt_sd_deg;
  if (head.photo) reported.photo_pixel_size_m = head.photo->pixel_size_m;
  return reported;
}

bool IsIn(const WorldBox& box, const Eigen::Vector2d& place) {
  return (place.array() >= box.min_in_world.array()).all() &&
         (place.array() <= box.max_in_world.array()).all();
}

}  // namespace

std::vector<ReportedMap> ReportedMapsOf(const Service& service, const FlightPicture& picture) {
  std::vector<ReportedMap> maps;
  for (const auto& map : picture.maps()) {
    maps.push_back(ReportedMapOf(service, picture, *map));
  }
  return maps;
}

std::optional<GroundPicture> LandingPictureOf(const FlightPicture& picture,
                                              const StoredSite& site) {
  const Eigen::Vector2d touchdown = picture.Frame().WorldFromGeo(site.touchdown).head<2>();
  const bool is_on_map =
      std::any_of(picture.maps().begin(), picture.maps().end(), [&touchdown](const auto& map) {
        return IsIn(BoxOfGrid(map->head.grid), touchdown);
      });
  if (!is_on_map) return std::nullopt;
  GroundPicture ground = GroundOf(picture, LandingBoxOf(site, picture.Frame()), kLandingPx);
  // The ground is to be seen as it is.
  if (!ground.photo_jpeg.empty()) ground.hazard_png.clear();
  return ground;
}

}  // namespace freelsd
