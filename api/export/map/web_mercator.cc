#include "api/export/map/web_mercator.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "api/export/map/pixel_places.h"

namespace freelsd {
namespace {

constexpr int kMaxZoom = 30;
// atan(sinh(pi)): the pyramid is square.
constexpr double kMaxLatitudeDeg = 85.05112877980659;
constexpr double kEquatorM = 2.0 * std::numbers::pi * 6378137.0;
// Farther from the origin no flight has a map.
constexpr double kMaxReachM = 100e3;
// Share of its sides by which a box exceeds the places on its edge that were projected.
constexpr double kBoxMarginRatio = 0.002;
// The shading of a cell needs its neighbours.
constexpr double kBoxMarginPx = 3.0;

// Pixels of the tile that are near enough to the origin, in pixels from the tile's corner.
cv::Rect2d NearPixels(const XyzTile& tile, const LocalFrame& frame) {
  const double size = WorldSizePx(tile.z);
  const Eigen::Vector2d corner = Eigen::Vector2d(tile.x, tile.y) * kTileSizePx;
  Eigen::Vector2d origin = PixelFromGeo(frame.origin(), tile.z) - corner;
  // The nearest of the copies of the world beside each other.
  origin.x() -= size * std::round((origin.x() - kTileSizePx / 2.0) / size);
  const double reach = kMaxReachM / PixelSizeM(tile.z, frame.origin().latitude_deg);
  const cv::Rect2d near(origin.x() - reach, origin.y() - reach, 2.0 * reach, 2.0 * reach);
  // The only tile that may hold a map at both of its edges.
  if (tile.z == 0) return near;
  return near & cv::Rect2d(0, 0, kTileSizePx, kTileSizePx);
}

}  // namespace

void XyzTile::Check() const {
  const auto check = [](const char* name, int value, int64_t end) {
    if (value >= 0 && value < end) return;
    throw std::invalid_argument("tile." + std::string(name) + " = " + std::to_string(value) +
                                ": must be 0 to " + std::to_string(end - 1));
  };
  check("z", z, kMaxZoom + 1);
  check("x", x, int64_t{1} << z);
  check("y", y, int64_t{1} << z);
}

double WorldSizePx(int zoom) { return std::ldexp(kTileSizePx, zoom); }

Eigen::Vector2d PixelFromGeo(const GeoPoint& place, int zoom) {
  const double latitude =
      RadFromDeg(std::clamp(place.latitude_deg, -kMaxLatitudeDeg, kMaxLatitudeDeg));
  const double x = place.longitude_deg / 360.0 + 0.5;
  const double y = 0.5 - std::asinh(std::tan(latitude)) / (2.0 * std::numbers::pi);
  return Eigen::Vector2d(x, y) * WorldSizePx(zoom);
}

GeoPoint GeoFromPixel(const Eigen::Vector2d& pixel, int zoom) {
  const Eigen::Vector2d share = pixel / WorldSizePx(zoom);
  const double latitude = std::atan(std::sinh(std::numbers::pi * (1.0 - 2.0 * share.y())));
  return {DegFromRad(latitude), 360.0 * (share.x() - 0.5), 0.0};
}

double PixelSizeM(int zoom, double latitude_deg) {
  const double latitude = std::clamp(latitude_deg, -kMaxLatitudeDeg, kMaxLatitudeDeg);
  return kEquatorM * std::cos(RadFromDeg(latitude)) / WorldSizePx(zoom);
}

GeoBounds BoundsOf(const XyzTile& tile) {
  tile.Check();
  const Eigen::Vector2d corner = Eigen::Vector2d(tile.x, tile.y) * kTileSizePx;
  const GeoPoint north_west = GeoFromPixel(corner, tile.z);
  const GeoPoint south_east =
      GeoFromPixel(corner + Eigen::Vector2d(kTileSizePx, kTileSizePx), tile.z);
  return {north_west.longitude_deg,
          south_east.latitude_deg,
          south_east.longitude_deg,
          north_west.latitude_deg};
}

XyzTile TileAt(const GeoPoint& place, int zoom) {
  XyzTile{zoom, 0, 0}.Check();
  const Eigen::Vector2d tile = PixelFromGeo(place, zoom) / kTileSizePx;
  const double last = std::ldexp(1.0, zoom) - 1.0;
  return {zoom,
          static_cast<int>(std::clamp(std::floor(tile.x()), 0.0, last)),
          static_cast<int>(std::clamp(std::floor(tile.y()), 0.0, last))};
}

std::optional<WorldBox> WorldBoxOf(const XyzTile& tile, const LocalFrame& local_frame) {
  tile.Check();
  const cv::Rect2d pixels = NearPixels(tile, local_frame);
  if (pixels.empty()) return std::nullopt;
  constexpr int kNumSteps = 16;
  WorldBox box;
  Eigen::AlignedBox2d places;
  const Eigen::Vector2d corner = Eigen::Vector2d(tile.x, tile.y) * kTileSizePx;
  for (int i = 0; i <= kNumSteps; ++i) {
    for (int j = 0; j <= kNumSteps; ++j) {
      const Eigen::Vector2d pixel(pixels.x + pixels.width * i / kNumSteps,
                                  pixels.y + pixels.height * j / kNumSteps);
      places.extend(PlaceInWorld(GeoFromPixel(corner + pixel, tile.z), local_frame));
    }
  }
  const Eigen::Vector2d margin =
      kBoxMarginRatio * places.sizes() +
      Eigen::Vector2d::Constant(kBoxMarginPx *
                                PixelSizeM(tile.z, local_frame.origin().latitude_deg));
  return WorldBox{places.min() - margin, places.max() + margin};
}

int LevelOf(const XyzTile& tile,
            const LocalFrame& local_frame,
            double finest_cell_size_m,
            int num_levels) {
  tile.Check();
  const double pixel_size_m = PixelSizeM(tile.z, local_frame.origin().latitude_deg);
  int level = 0;
  while (level + 1 < num_levels && std::ldexp(finest_cell_size_m, level + 1) <= pixel_size_m) {
    ++level;
  }
  return level;
}

}  // namespace freelsd
