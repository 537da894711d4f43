#include "engine/watch/strip_canvas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Over this distance, the heights and the projection are nearly linear.
constexpr double kNodeSpacingM = 1.0;
// The stored picture is halved in size only where the photograph is coarser by this.
constexpr double kRoundingOfFactor = 0.25;
constexpr int kMaxNumFillRounds = 64;

// Fills holes from their borders inwards.
cv::Mat1f Filled(const cv::Mat1f& elevation) {
  cv::Mat1f height = elevation.clone();
  cv::Mat1b is_known(height.size());
  for (int i = 0; i < static_cast<int>(height.total()); ++i) {
    is_known(i / height.cols, i % height.cols) =
        std::isnan(height(i / height.cols, i % height.cols)) ? 0 : 255;
  }
  const int num_known = cv::countNonZero(is_known);
  if (num_known == 0) return {};
  const float mean = static_cast<float>(cv::mean(height, is_known)[0]);
  height.setTo(0.0f, is_known == 0);
  for (int round = 0; round < kMaxNumFillRounds; ++round) {
    if (cv::countNonZero(is_known) == static_cast<int>(is_known.total())) return height;
    cv::Mat1f weight(height.size()), sum, weights;
    is_known.convertTo(weight, CV_32F, 1.0 / 255.0);
    cv::boxFilter(height, sum, CV_32F, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
    cv::boxFilter(weight, weights, CV_32F, {3, 3}, {-1, -1}, false, cv::BORDER_CONSTANT);
    const cv::Mat1b is_next = (weights > 0.5f) & (is_known == 0);
    cv::Mat1f(sum / weights).copyTo(height, is_next);
    is_known |= is_next;
  }
  height.setTo(mean, is_known == 0);
  return height;
}

float BilinearAt(const cv::Mat1f& raster, const Grid& grid, const Eigen::Vector2d& place) {
  const double u = (place.x() - grid.north_west_in_world.x()) / grid.cell_size_m - 0.5;
  const double v = (grid.north_west_in_world.y() - place.y()) / grid.cell_size_m - 0.5;
  const double col = std::clamp(u, 0.0, raster.cols - 1.0);
  const double row = std::clamp(v, 0.0, raster.rows - 1.0);
  const int left = std::min(static_cast<int>(col), std::max(raster.cols - 2, 0));
  const int top = std::min(static_cast<int>(row), std::max(raster.rows - 2, 0));
  const int right = std::min(left + 1, raster.cols - 1);
  const int bottom = std::min(top + 1, raster.rows - 1);
  const auto tu = static_cast<float>(col - left), tv = static_cast<float>(row - top);
  const float upper = raster(top, left) * (1 - tu) + raster(top, right) * tu;
  const float lower = raster(bottom, left) * (1 - tu) + raster(bottom, right) * tu;
  return upper * (1 - tv) + lower * tv;
}

std::optional<Eigen::Vector2d> ImageOf(const WatchedPhoto& photo,
                                       const Rigid3d& camera_from_world,
                                       const Eigen::Vector2d& place,
                                       double height) {
  return photo.camera.ImageFromCamera(camera_from_world *
                                      Eigen::Vector3d(place.x(), place.y(), height));
}

// A photograph that is much finer than the canvas is reduced first, or details would be skipped.
WatchedPhoto Reduced(const WatchedPhoto& photo, double factor) {
  if (factor >= 1.0) return photo;
  WatchedPhoto reduced = photo;
  reduced.camera = photo.camera.Scaled(factor);
  const cv::Size size(reduced.camera.width_px, reduced.camera.height_px);
  cv::resize(photo.image, reduced.image, size, 0.0, 0.0, cv::INTER_AREA);
  return reduced;
}

}  // namespace

StripGround::StripGround(const StripPicture& strip)
    : strip_(strip), height_(Filled(strip.elevation)) {
  highest_ = -std::numeric_limits<double>::infinity();
  for (const float upper : strip.upper) {
    if (!std::isnan(upper)) highest_ = std::max(highest_, static_cast<double>(upper));
  }
}

double StripGround::HeightAt(const Eigen::Vector2d& place_in_world) const {
  return BilinearAt(height_, strip_.ground_grid, place_in_world);
}

bool StripGround::IsHidden(const Eigen::Vector2d& place_in_world,
                           const Eigen::Vector3d& eye_in_world,
                           double hidden_height_m) const {
  const double ground = HeightAt(place_in_world);
  const Eigen::Vector2d way = eye_in_world.head<2>() - place_in_world;
  const double distance = way.norm(), climb = eye_in_world.z() - ground;
  if (distance <= 0.0 || climb <= 0.0) return false;
  const double step = strip_.ground_grid.cell_size_m;
  for (double gone = step; gone < distance; gone += step) {
    const double sight = ground + climb * gone / distance;
    if (sight > highest_) return false;
    const auto cell = strip_.ground_grid.CellAt(place_in_world + way * (gone / distance));
    if (!cell) return false;
    const float upper = strip_.upper(*cell);
    if (!std::isnan(upper) && upper > sight + hidden_height_m) return true;
  }
  return false;
}

Eigen::Vector2d StripCanvas::PlaceAt(double col, double row) const {
  return grid.north_west_in_world + grid.cell_size_m * Eigen::Vector2d(col + 0.5, -(row + 0.5));
}

StripExtent ExtentOf(const StripPicture& strip) {
  StripExtent extent{Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()),
                     Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity())};
  for (const Polygon& outline : strip.outlines) {
    for (const Eigen::Vector2d& corner : outline) {
      extent.low = extent.low.cwiseMin(corner);
      extent.high = extent.high.cwiseMax(corner);
    }
  }
  return extent;
}

StripCanvas MakeCanvas(const StripPicture& strip, double sampling_m, const WatchOptions& options) {
  const double stored_m = strip.grid.cell_size_m;
  const double wanted_m = std::max(options.min_pixel_m, sampling_m);
  const int factor = std::max(1, static_cast<int>(wanted_m / stored_m + kRoundingOfFactor));
  const StripExtent extent = ExtentOf(strip);
  const Polygon box{extent.low,
                    {extent.high.x(), extent.low.y()},
                    extent.high,
                    {extent.low.x(), extent.high.y()}};
  cv::Rect cells = strip.grid.CellsAround(box, options.context_m) &
                   cv::Rect(0, 0, strip.grid.num_cols, strip.grid.num_rows);
  cells.width -= cells.width % factor;
  cells.height -= cells.height % factor;
  StripCanvas canvas;
  if (cells.empty()) return canvas;
  canvas.grid = strip.grid.Part(cells);
  canvas.grid.cell_size_m = stored_m * factor;
  canvas.grid.num_rows = cells.height / factor;
  canvas.grid.num_cols = cells.width / factor;
  const cv::Size size(canvas.grid.num_cols, canvas.grid.num_rows);
  std::vector<cv::Mat1b> channels;
  cv::split(strip.picture(cells), channels);
  cv::Mat1b alpha;
  cv::resize(channels[3], alpha, size, 0.0, 0.0, cv::INTER_AREA);
  canvas.is_shown = alpha == 255;
  channels.pop_back();
  cv::Mat3b color;
  cv::merge(channels, color);
  color.convertTo(canvas.picture, CV_32F);
  cv::resize(canvas.picture, canvas.picture, size, 0.0, 0.0, cv::INTER_AREA);
  canvas.is_strip = cv::Mat1b::zeros(size);
  for (const Polygon& outline : strip.outlines) {
    for (const cv::Point& cell : canvas.grid.CellsIn(outline)) canvas.is_strip(cell) = 255;
  }
  return canvas;
}

std::optional<double> SamplingAt(const WatchedPhoto& photo,
                                 const StripGround& ground,
                                 const Eigen::Vector2d& place_in_world) {
  constexpr double kStepM = 0.5;
  const Rigid3d camera_from_world = Inverse(photo.world_from_camera);
  const double height = ground.HeightAt(place_in_world);
  const auto image_of = [&](const Eigen::Vector2d& place) {
    return ImageOf(photo, camera_from_world, place, height);
  };
  const auto here = image_of(place_in_world);
  const auto east = image_of(place_in_world + Eigen::Vector2d(kStepM, 0.0));
  const auto north = image_of(place_in_world + Eigen::Vector2d(0.0, kStepM));
  if (!here || !east || !north || !photo.camera.IsInside(*here)) return std::nullopt;
  Eigen::Matrix2d pixels_per_metre;
  pixels_per_metre << (*east - *here) / kStepM, (*north - *here) / kStepM;
  const double smallest = pixels_per_metre.jacobiSvd().singularValues()[1];
  if (smallest <= 0.0) return std::nullopt;
  return 1.0 / smallest;
}

ProjectedPhoto Project(const WatchedPhoto& photo,
                       const StripGround& ground,
                       const StripCanvas& canvas,
                       const Displacement& displacement) {
  const double pixel_m = canvas.grid.cell_size_m;
  const double distance = (photo.world_from_camera.translation.head<2>() -
                           canvas.PlaceAt(0.5 * canvas.picture.cols, 0.5 * canvas.picture.rows))
                              .norm();
  const double depth = std::hypot(
      distance,
      photo.world_from_camera.translation.z() -
          ground.HeightAt(canvas.PlaceAt(0.5 * canvas.picture.cols, 0.5 * canvas.picture.rows)));
  const WatchedPhoto reduced = Reduced(photo, depth / photo.camera.MeanFocalPx() / pixel_m);
  const Rigid3d camera_from_world = Inverse(photo.world_from_camera);
  const int spacing_px = std::max(1, static_cast<int>(kNodeSpacingM / pixel_m));
  const cv::Mat2f table =
      RemapTable(canvas.picture.size(), spacing_px, [&](double col, double row) {
        const Eigen::Vector2d moved = Eigen::Vector2d(col, row) + displacement(col, row);
        return ImageOf(reduced,
                       camera_from_world,
                       canvas.PlaceAt(moved.x(), moved.y()),
                       ground.HeightAt(canvas.PlaceAt(col, row)));
      });
  ProjectedPhoto projected;
  cv::Mat3f source;
  reduced.image.convertTo(source, CV_32F);
  cv::remap(
      source, projected.picture, table, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  projected.is_shown.create(table.size());
  const float right = static_cast<float>(source.cols - 2), bottom = float(source.rows - 2);
  for (int row = 0; row < table.rows; ++row) {
    for (int col = 0; col < table.cols; ++col) {
      const cv::Vec2f& at = table(row, col);
      projected.is_shown(row, col) =
          at[0] >= 1.0f && at[1] >= 1.0f && at[0] <= right && at[1] <= bottom ? 255 : 0;
    }
  }
  return projected;
}

cv::Mat1b ComparableGround(const StripCanvas& canvas,
                           const StripGround& ground,
                           const WatchedPhoto& photo,
                           const WatchOptions& options) {
  constexpr double kSquareM = 0.5;
  const int side = std::max(1, static_cast<int>(kSquareM / canvas.grid.cell_size_m));
  const Eigen::Vector3d& eye_in_world = photo.world_from_camera.translation;
  cv::Mat1b is_comparable(canvas.picture.size(), uchar{255});
  for (int row = 0; row < is_comparable.rows; row += side) {
    for (int col = 0; col < is_comparable.cols; col += side) {
      const cv::Rect square = cv::Rect(col, row, side, side) & cv::Rect({}, is_comparable.size());
      if (cv::countNonZero(canvas.is_strip(square)) == 0) continue;
      const Eigen::Vector2d place = canvas.PlaceAt(col + 0.5 * (side - 1), row + 0.5 * (side - 1));
      const double sampling = SamplingAt(photo, ground, place).value_or(0.0);
      if (sampling > options.max_sampling_m ||
          ground.IsHidden(place, eye_in_world, options.hidden_height_m)) {
        is_comparable(square).setTo(0);
      }
    }
  }
  return is_comparable;
}

}  // namespace freelsd
