#include <algorithm>
#include <cmath>

#include "engine/selection/selection.h"

namespace freelsd {

cv::Mat1b GrassMask(const Segments& segments, const Labels& labels) {
  std::vector<uint8_t> value_of_label(1, 0);
  for (size_t i = 0; i < segments.segments.size(); ++i) {
    const size_t label = static_cast<size_t>(segments.segments[i].label);
    if (value_of_label.size() <= label) value_of_label.resize(label + 1, 0);
    if (labels[i].surface == Surface::kUnsure) continue;
    value_of_label[label] = static_cast<uint8_t>(1 + std::lround(254.0 * labels[i].probability));
  }
  cv::Mat1b mask(segments.labels.size(), 0);
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const size_t label = static_cast<size_t>(segments.labels(row, col));
      if (label < value_of_label.size()) mask(row, col) = value_of_label[label];
    }
  }
  return mask;
}

PackedMask Packed(const cv::Mat1b& mask, double image_px_per_mask_px) {
  PackedMask packed{mask.size(), {}, image_px_per_mask_px};
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      const uint8_t value = mask(row, col);
      if (packed.runs.empty() || packed.runs.back().value != value) {
        packed.runs.push_back({value, 0});
      }
      ++packed.runs.back().length;
    }
  }
  packed.runs.shrink_to_fit();
  return packed;
}

cv::Mat1b PackedMask::Unpack() const {
  cv::Mat1b mask(size);
  uint8_t* pixel = mask.data;
  for (const Run& run : runs) pixel = std::fill_n(pixel, run.length, run.value);
  return mask;
}

std::vector<GrassView> AdjustedGrassViews(const Snapshot& snapshot,
                                          const std::vector<size_t>& indices,
                                          const AdjustedBlock& block) {
  std::vector<GrassView> views;
  for (size_t i = 0; i < indices.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    const PackedMask& packed = snapshot.grass_masks[indices[i]];
    views.push_back({block.views[i].world_from_camera,
                     block.CameraOf(i),
                     packed.Unpack(),
                     packed.image_px_per_mask_px});
  }
  return views;
}

}  // namespace freelsd
