#include "server/recall/other_maps/map_places.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {

Places::Places(const LocalFrame& from, const LocalFrame& to, const Eigen::Vector2d& around)
    : around_(around) {
  constexpr double kStepM = 100.0;
  const auto at = [&](const Eigen::Vector2d& place) -> Eigen::Vector2d {
    GeoPoint geo = from.GeoFromWorld({place.x(), place.y(), 0.0});
    geo.altitude_m = to.origin().altitude_m;
    return to.WorldFromGeo(geo).head<2>();
  };
  shift_ = at(around);
  rotation_.col(0) = (at(around + kStepM * Eigen::Vector2d::UnitX()) - shift_) / kStepM;
  rotation_.col(1) = (at(around + kStepM * Eigen::Vector2d::UnitY()) - shift_) / kStepM;
}

Eigen::Vector2d MiddleOf(const Grid& grid) {
  return grid.north_west_in_world +
         0.5 * grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
}

cv::Mat1f HighestWithin(const cv::Mat1f& heights, int half) {
  cv::Mat1f known = heights.clone();
  cv::patchNaNs(known, kNoGround);
  if (half == 0) return known;
  cv::Mat1f highest;
  cv::dilate(known,
             highest,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1}),
             cv::Point(-1, -1),
             1,
             cv::BORDER_CONSTANT,
             cv::Scalar::all(kNoGround));
  return highest;
}

float ValueAtRank(std::vector<float>& values, double rank) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(rank * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace freelsd
