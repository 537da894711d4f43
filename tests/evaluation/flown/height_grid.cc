#include "tests/evaluation/flown/height_grid.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

struct Extent {
  GeoPoint south_west{90.0, 180.0, 0.0};
  GeoPoint north_east{-90.0, -180.0, 0.0};
};

Extent ExtentOf(const Mosaic& mosaic) {
  Extent extent;
  for (const World& world : mosaic.worlds()) {
    const LocalFrame frame(world.origin);
    const double half = 0.5 * world.size_m;
    for (const double sign : {-1.0, 1.0}) {
      const GeoPoint corner = frame.GeoFromWorld({sign * half, sign * half, 0.0});
      extent.south_west.latitude_deg =
          std::min(extent.south_west.latitude_deg, corner.latitude_deg);
      extent.south_west.longitude_deg =
          std::min(extent.south_west.longitude_deg, corner.longitude_deg);
      extent.north_east.latitude_deg =
          std::max(extent.north_east.latitude_deg, corner.latitude_deg);
      extent.north_east.longitude_deg =
          std::max(extent.north_east.longitude_deg, corner.longitude_deg);
    }
  }
  return extent;
}

void Write(const std::filesystem::path& path, const char* bytes, size_t size) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes, static_cast<std::streamsize>(size));
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace

void WriteHeightGrid(const Mosaic& mosaic, double cell_size_m, const std::filesystem::path& path) {
  const Extent extent = ExtentOf(mosaic);
  const Eigen::Vector2d size_m =
      LocalFrame(extent.south_west).WorldFromGeo(extent.north_east).head<2>();
  const int num_cols = static_cast<int>(std::lround(size_m.x() / cell_size_m));
  const int num_rows = static_cast<int>(std::lround(size_m.y() / cell_size_m));
  const double step_latitude_deg =
      (extent.north_east.latitude_deg - extent.south_west.latitude_deg) / num_rows;
  const double step_longitude_deg =
      (extent.north_east.longitude_deg - extent.south_west.longitude_deg) / num_cols;
  const double south_deg = extent.south_west.latitude_deg + 0.5 * step_latitude_deg;
  const double west_deg = extent.south_west.longitude_deg + 0.5 * step_longitude_deg;
  std::vector<float> altitudes_m;
  altitudes_m.reserve(static_cast<size_t>(num_rows) * static_cast<size_t>(num_cols));
  for (int row = 0; row < num_rows; ++row) {
    for (int col = 0; col < num_cols; ++col) {
      GeoPoint place{south_deg + row * step_latitude_deg,
                     west_deg + col * step_longitude_deg,
                     mosaic.origin().altitude_m};
      // Heights are above the tangent plane of the world.
      const double height = mosaic.PlaceOf(place).HeightAbove();
      altitudes_m.push_back(static_cast<float>(place.altitude_m - height));
    }
  }
  const nlohmann::json header{
      {"latitude_deg", south_deg},
      {"longitude_deg", west_deg},
      {"latitude_step_deg", step_latitude_deg},
      {"longitude_step_deg", step_longitude_deg},
      {"num_rows", num_rows},
      {"num_cols", num_cols},
      {"lowest_ground_m", *std::min_element(altitudes_m.begin(), altitudes_m.end())}};
  const std::string text = header.dump();
  Write(path.string() + ".json", text.data(), text.size());
  Write(path.string() + ".f32",
        reinterpret_cast<const char*>(altitudes_m.data()),
        altitudes_m.size() * sizeof(float));
}

}  // namespace freelsd
