#include <algorithm>
#include <cmath>

#include "api/export/map/map_picture.h"

namespace freelsd {
namespace {

// More of them per side of a pixel cost more than they improve it.
constexpr int kMaxNumPhotoSteps = 4;

class PhotoFinder {
 public:
  explicit PhotoFinder(const std::vector<PhotoWindow>& windows) {
    for (const PhotoWindow& window : windows) {
      CheckWindow(window);
      windows_.push_back({&window.pixels,
                          window.grid.north_west_in_world.x(),
                          window.grid.north_west_in_world.y(),
                          1.0 / window.grid.cell_size_m});
    }
  }

  // Transparent where no window has seen the place.
  cv::Vec4b At(const Eigen::Vector2d& place) const {
    for (const Placed& placed : windows_) {
      const double x = (place.x() - placed.west) * placed.pixels_per_m;
      const double y = (placed.north - place.y()) * placed.pixels_per_m;
      if (!(x >= 0.0 && y >= 0.0 && x < placed.pixels->cols && y < placed.pixels->rows)) continue;
      const cv::Vec4b& pixel = (*placed.pixels)(static_cast<int>(y), static_cast<int>(x));
      if (pixel[3] > 0) return pixel;
    }
    return {0, 0, 0, 0};
  }

 private:
  struct Placed {
    const cv::Mat4b* pixels;
    double west, north, pixels_per_m;
  };
  std::vector<Placed> windows_;
};

int NumSteps(double pixel_size_m, const std::vector<PhotoWindow>& windows) {
  double steps = 1.0;
  for (const PhotoWindow& window : windows) {
    steps = std::max(steps, pixel_size_m / window.grid.cell_size_m);
  }
  return std::min(kMaxNumPhotoSteps, static_cast<int>(std::lround(steps)));
}

// Sum of the colours of a pixel, each times its alpha.
struct ColorSum {
  cv::Vec3i color{0, 0, 0};
  int weight = 0;

  void Add(const cv::Vec4b& pixel) {
    for (int i = 0; i < 3; ++i) color[i] += pixel[i] * pixel[3];
    weight += pixel[3];
  }
  cv::Vec4b Mean(int num_samples) const {
    if (weight == 0) return {0, 0, 0, 0};
    cv::Vec4b mean;
    for (int i = 0; i < 3; ++i) {
      mean[i] = static_cast<uint8_t>((color[i] + weight / 2) / weight);
    }
    mean[3] = static_cast<uint8_t>((weight + num_samples / 2) / num_samples);
    return mean;
  }
};

}  // namespace

cv::Mat4b PhotoPicture(const PixelPlaces& places, const std::vector<PhotoWindow>& windows) {
  const cv::Rect& box = places.box();
  const PhotoFinder finder(windows);
  const int num_steps = NumSteps(places.pixel_size_m(), windows);
  const double step = 1.0 / num_steps;
  cv::Mat4b picture(box.size());
  for (int row = 0; row < box.height; ++row) {
    std::vector<ColorSum> sums(box.width);
    for (int i = 0; i < num_steps; ++i) {
      const auto line = places.Row(
          {box.x + 0.5 * step, box.y + row + (i + 0.5) * step}, step, num_steps * box.width);
      for (size_t j = 0; j < line.size(); ++j) sums[j / num_steps].Add(finder.At(line[j]));
    }
    for (int col = 0; col < box.width; ++col) {
      picture(row, col) = sums[col].Mean(num_steps * num_steps);
    }
  }
  return picture;
}

std::string PatchPng(const cv::Mat& image, const cv::Rect& wanted) {
  const cv::Rect inside = wanted & cv::Rect({0, 0}, image.size());
  cv::Mat patch = cv::Mat::zeros(wanted.size(), image.type());
  if (!inside.empty()) image(inside).copyTo(patch(inside - wanted.tl()));
  return EncodePng(patch);
}

}  // namespace freelsd
