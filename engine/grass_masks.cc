#include "engine/grass_masks.h"

#include <cmath>
#include <utility>

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

std::vector<GrassView> AdjustedGrassViews(const Snapshot& snapshot,
                                          const std::vector<size_t>& indices,
                                          const AdjustedBlock& block) {
  std::vector<GrassView> views;
  for (size_t i = 0; i < indices.size(); ++i) {
    if (!block.views[i].is_connected) continue;
    GrassView view = snapshot.grass_views[indices[i]];
    view.world_from_camera = block.views[i].world_from_camera;
    view.camera = block.CameraOf(i);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace freelsd
