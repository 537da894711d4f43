#include "api/export/map/pixel_places.h"

#include <algorithm>

namespace freelsd {
namespace {

constexpr int kSpacingPx = 16;
// Beyond this the axes of a picture turn too much within the spacing.
constexpr double kMaxInterpolatedPixelSizeM = 400.0;

}  // namespace

Eigen::Vector2d PlaceInWorld(const GeoPoint& place, const LocalFrame& local_frame) {
  GeoPoint on_plane = place;
  on_plane.altitude_m = local_frame.origin().altitude_m;
  // The plane is tangent to the curved earth, so it is above the place.
  on_plane.altitude_m -= local_frame.WorldFromGeo(on_plane).z();
  return local_frame.WorldFromGeo(on_plane).head<2>();
}

PixelPlaces::PixelPlaces(const PictureFrame& picture,
                         const cv::Rect& box,
                         const LocalFrame& local_frame)
    : box_(box),
      pixel_size_m_(picture.pixel_size_m),
      spacing_px_(picture.pixel_size_m > kMaxInterpolatedPixelSizeM ? 1 : kSpacingPx),
      num_rows_((box.height + spacing_px_ - 1) / spacing_px_ + 1),
      num_cols_((box.width + spacing_px_ - 1) / spacing_px_ + 1) {
  nodes_.reserve(static_cast<size_t>(num_rows_) * num_cols_);
  for (int row = 0; row < num_rows_; ++row) {
    for (int col = 0; col < num_cols_; ++col) {
      const Eigen::Vector2d position(box.x + col * spacing_px_, box.y + row * spacing_px_);
      nodes_.push_back(PlaceInWorld(picture.geo_from_position(position), local_frame));
    }
  }
}

WorldBox PixelPlaces::BoxInWorld() const {
  constexpr double kMarginPx = 3.0;
  Eigen::AlignedBox2d places;
  for (const Eigen::Vector2d& node : nodes_) places.extend(node);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kMarginPx * pixel_size_m_);
  return {places.min() - margin, places.max() + margin};
}

double PixelPlaces::PixelExtentM() const {
  double extent = 0.0;
  for (int row = 0; row + 1 < num_rows_; ++row) {
    for (int col = 0; col + 1 < num_cols_; ++col) {
      const Eigen::Vector2d node = Node(row, col);
      for (const Eigen::Vector2d& next : {Node(row + 1, col), Node(row, col + 1)}) {
        extent = std::max(extent, (next - node).lpNorm<1>() / spacing_px_);
      }
    }
  }
  return extent;
}

std::vector<Eigen::Vector2d> PixelPlaces::Row(const Eigen::Vector2d& first,
                                              double step,
                                              int count) const {
  const double node_row = (first.y() - box_.y) / spacing_px_;
  const int row = std::clamp(static_cast<int>(node_row), 0, std::max(0, num_rows_ - 2));
  const double row_part = node_row - row;
  std::vector<Eigen::Vector2d> line(num_cols_);
  for (int col = 0; col < num_cols_; ++col) {
    line[col] = (1.0 - row_part) * Node(row, col) + row_part * Node(row + 1, col);
  }
  std::vector<Eigen::Vector2d> places(count);
  for (int i = 0; i < count; ++i) {
    const double node_col = (first.x() - box_.x + i * step) / spacing_px_;
    const int col = std::clamp(static_cast<int>(node_col), 0, num_cols_ - 2);
    const double part = node_col - col;
    places[i] = (1.0 - part) * line[col] + part * line[col + 1];
  }
  return places;
}

}  // namespace freelsd
