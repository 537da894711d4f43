#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/ground_kind/ground_kind.h"

namespace freelsd {
namespace {

struct Sum {
  int64_t told = 0;
  int64_t num_told = 0;
  int64_t num_pixels = 0;
};

}  // namespace

Labels LabelsOf(const Segments& segments,
                const KindPicture& picture,
                const ClassificationOptions& options) {
  std::vector<Sum> sums(segments.segments.size() + 1);
  const double scale = segments.image_px_per_working_px / picture.image_px_per_px;
  const auto at = [scale](int pixel, int count) {
    return std::clamp(static_cast<int>((pixel + 0.5) * scale), 0, count - 1);
  };
  for (int row = 0; row < segments.labels.rows; ++row) {
    const uint8_t* told = picture.grass[at(row, picture.grass.rows)];
    for (int col = 0; col < segments.labels.cols; ++col) {
      Sum& sum = sums[static_cast<size_t>(segments.labels(row, col))];
      const uint8_t value = told[at(col, picture.grass.cols)];
      ++sum.num_pixels;
      if (value == 0) continue;
      ++sum.num_told;
      sum.told += value - 1;
    }
  }
  Labels labels;
  for (const Segment& segment : segments.segments) {
    const Sum& sum = sums[static_cast<size_t>(segment.label)];
    Label label;
    if (2 * sum.num_told > sum.num_pixels) {
      label.probability =
          static_cast<double>(sum.told) / (254.0 * static_cast<double>(sum.num_told));
      label.surface = SurfaceOf(label.probability, options);
    }
    labels.push_back(label);
  }
  return labels;
}

KindPicture PictureOf(const Segments& segments, const Labels& labels) {
  std::vector<uint8_t> value_of_label(segments.segments.size() + 1, 0);
  for (size_t i = 0; i < segments.segments.size(); ++i) {
    if (labels[i].surface == Surface::kUnsure) continue;
    value_of_label[static_cast<size_t>(segments.segments[i].label)] =
        static_cast<uint8_t>(1 + std::lround(254.0 * labels[i].probability));
  }
  KindPicture picture{cv::Mat1b(segments.labels.size()), {}, segments.image_px_per_working_px};
  std::transform(
      segments.labels.begin(), segments.labels.end(), picture.grass.begin(), [&](int label) {
        return value_of_label[static_cast<size_t>(label)];
      });
  return picture;
}

}  // namespace freelsd
