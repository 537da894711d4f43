#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/cover/cover.h"
#include "engine/cover/steepest_view.h"

namespace freelsd {
namespace {

// A map cell is a whole number of orthophoto cells.
int CellsPerMapCell(const ElevationMap& map, const PhotoOptions& options) {
  const double ratio = map.grid.cell_size_m / options.orthophoto_cell_size_m;
  return std::max(1, static_cast<int>(std::lround(ratio)));
}

// An image scaled so that its pixels are about as large on the ground as the orthophoto's cells.
// Without scaling, a cell would sample one pixel of many.
struct ScaledImage {
  cv::Mat image;
  double pixels_per_pixel = 1.0;
};

ScaledImage ScaleTo(const cv::Mat& image, double ground_sampling_m, double cell_size_m) {
  const double factor = std::min(1.0, ground_sampling_m / cell_size_m);
  if (factor > 0.75) return {image, 1.0};
  ScaledImage scaled;
  cv::resize(image, scaled.image, {}, factor, factor, cv::INTER_AREA);
  scaled.pixels_per_pixel = static_cast<double>(scaled.image.cols) / image.cols;
  return scaled;
}

// Bilinear; the border repeats.
cv::Vec3b Sample(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const double x = std::clamp(pixel.x(), 0.0, std::max(0.0, image.cols - 1.001));
  const double y = std::clamp(pixel.y(), 0.0, std::max(0.0, image.rows - 1.001));
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const int right = std::min(left + 1, image.cols - 1), bottom = std::min(top + 1, image.rows - 1);
  const double u = x - left, v = y - top;
  const auto weigh = [&](auto at) {
    const double upper = (1.0 - u) * at(top, left) + u * at(top, right);
    const double lower = (1.0 - u) * at(bottom, left) + u * at(bottom, right);
    return static_cast<uint8_t>(std::lround((1.0 - v) * upper + v * lower));
  };
  if (image.channels() == 1) {
    const uint8_t grey =
        weigh([&](int row, int col) { return double(image.at<uint8_t>(row, col)); });
    return {grey, grey, grey};
  }
  cv::Vec3b color;
  for (int c = 0; c < 3; ++c) {
    color[c] = weigh([&](int row, int col) { return double(image.at<cv::Vec3b>(row, col)[c]); });
  }
  return color;
}

class CellPainter {
 public:
  CellPainter(const ElevationMap& map,
              const AdjustedBlock& block,
              size_t view,
              const ScaledImage& scaled)
      : map_(map),
        camera_(block.CameraOf(view)),
        camera_from_world_(Inverse(block.views[view].world_from_camera)),
        scaled_(scaled) {}

  // Interpolates image positions between the corners of the cell.
  void Paint(int row, int col, int num_parts, cv::Mat3b& image, cv::Mat1b& seen) const {
    Eigen::Vector2d corners[4];
    for (int i = 0; i < 4; ++i) {
      const int south = i / 2, east = i % 2;
      const auto corner = ImageOfCorner(
          map_, camera_, camera_from_world_, row + south, col + east, map_.elevation(row, col));
      if (!corner) return;
      corners[i] = *corner;
    }
    for (int i = 0; i < num_parts * num_parts; ++i) {
      const int south = i / num_parts, east = i % num_parts;
      const double v = (south + 0.5) / num_parts, u = (east + 0.5) / num_parts;
      const Eigen::Vector2d pixel = (1.0 - v) * ((1.0 - u) * corners[0] + u * corners[1]) +
                                    v * ((1.0 - u) * corners[2] + u * corners[3]);
      const Eigen::Vector2d in_scaled = (pixel.array() + 0.5) * scaled_.pixels_per_pixel - 0.5;
      const cv::Point cell(col * num_parts + east, row * num_parts + south);
      image(cell) = Sample(scaled_.image, in_scaled);
      seen(cell) = 255;
    }
  }

 private:
  const ElevationMap& map_;
  const Camera camera_;
  const Rigid3d camera_from_world_;
  const ScaledImage& scaled_;
};

// Around the map cells that are taken from each view; empty if none is.
std::vector<cv::Rect> CellsOfViews(const Orthophoto& photo, size_t num_views) {
  std::vector<cv::Rect> around(num_views);
  for (int row = 0; row < photo.view.rows; ++row) {
    for (int col = 0; col < photo.view.cols; ++col) {
      for (const int view : {photo.view(row, col), photo.second_view(row, col)}) {
        if (view >= 0) around[static_cast<size_t>(view)] |= cv::Rect(col, row, 1, 1);
      }
    }
  }
  return around;
}

}  // namespace

Orthophoto MakeOrthophoto(const ElevationMap& map,
                          const AdjustedBlock& block,
                          const ImageSource& images,
                          const PhotoOptions& options) {
  Orthophoto photo;
  if (map.elevation.empty()) return photo;
  const int num_parts = CellsPerMapCell(map, options);
  photo.grid = map.grid;
  photo.grid.cell_size_m /= num_parts;
  photo.grid.num_rows *= num_parts;
  photo.grid.num_cols *= num_parts;
  const cv::Size size(photo.grid.num_cols, photo.grid.num_rows);
  photo.image = cv::Mat3b::zeros(size);
  photo.seen = cv::Mat1b::zeros(size);
  photo.view = SteepestViews(map, block);
  photo.second_view = cv::Mat1i(photo.view.size(), -1);
  if (options.max_photo_disagreement > 0.0) {
    photo.second_image = cv::Mat3b::zeros(size);
    photo.second_seen = cv::Mat1b::zeros(size);
    photo.second_view = SteepestViews(map, block, photo.view, options.min_crossing_ratio);
  }
  const std::vector<cv::Rect> cells = CellsOfViews(photo, block.views.size());
  for (size_t v = 0; v < block.views.size(); ++v) {
    const int number = static_cast<int>(v);
    if (cells[v].empty()) continue;
    const cv::Mat image = images(block.views[v].frame_id);
    if (image.empty()) continue;
    const double ground_sampling_m =
        block.views[v].height_above_ground / block.camera.MeanFocalPx();
    const ScaledImage scaled = ScaleTo(image, ground_sampling_m, photo.grid.cell_size_m);
    const CellPainter painter(map, block, v, scaled);
    cv::parallel_for_({cells[v].y, cells[v].br().y}, [&](const cv::Range& rows) {
      for (int row = rows.start; row < rows.end; ++row) {
        for (int col = cells[v].x; col < cells[v].br().x; ++col) {
          if (photo.view(row, col) == number) {
            painter.Paint(row, col, num_parts, photo.image, photo.seen);
          } else if (photo.second_view(row, col) == number) {
            painter.Paint(row, col, num_parts, photo.second_image, photo.second_seen);
          }
        }
      }
    });
  }
  return photo;
}

}  // namespace freelsd
