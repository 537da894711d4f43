#include "api/export/hillshade.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace freelsd {

double Hillshade(const cv::Mat1f& elevation, int row, int col, double cell_size_m) {
  const auto height_at = [&](int r, int c) {
    const bool is_inside = r >= 0 && c >= 0 && r < elevation.rows && c < elevation.cols;
    const float height = is_inside ? elevation(r, c) : std::nanf("");
    return std::isfinite(height) ? height : elevation(row, col);
  };
  const double east = (height_at(row, col + 1) - height_at(row, col - 1)) / (2.0 * cell_size_m);
  const double north = (height_at(row - 1, col) - height_at(row + 1, col)) / (2.0 * cell_size_m);
  const Eigen::Vector3d normal = Eigen::Vector3d(-east, -north, 1.0).normalized();
  const Eigen::Vector3d light = Eigen::Vector3d(-1.0, 1.0, std::sqrt(2.0)).normalized();
  return std::max(0.0, normal.dot(light));
}

Color Shade(const Color& color, double brightness) {
  // Flat ground keeps its colour.
  constexpr double kFlatBrightness = 0.7071;
  const double factor = 0.4 + 0.6 * brightness / kFlatBrightness;
  Color shaded;
  for (int i = 0; i < 3; ++i) shaded[i] = cv::saturate_cast<uint8_t>(color[i] * factor);
  return shaded;
}

}  // namespace freelsd
