#include "engine/cover/crop_fields.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_features.h"

namespace freelsd {
namespace {

// A smaller field has no reliable colour.
constexpr int kMinNumCells = 100;

struct FieldColor {
  std::array<float, 3> median{};
  std::array<float, 3> deviation{};
};

// Leaves out the border, whose colour is mixed with that of the neighbour.
std::optional<FieldColor> ColorOfField(const cv::Mat1b& field,
                                       const ColorPlanes& colors,
                                       const cv::Mat1b& is_seen) {
  cv::Mat1b inner;
  cv::erode(field, inner, cv::Mat1b::ones(5, 5));
  inner &= is_seen;
  FieldColor color;
  for (size_t i = 0; i < 3; ++i) {
    std::vector<float> values;
    for (int row = 0; row < inner.rows; ++row) {
      for (int col = 0; col < inner.cols; ++col) {
        if (inner(row, col)) values.push_back(colors[i](row, col));
      }
    }
    if (values.size() < kMinNumCells) return std::nullopt;
    std::sort(values.begin(), values.end());
    const size_t n = values.size();
    color.median[i] = values[n / 2];
    color.deviation[i] =
        std::max(0.5f * (values[n * 84 / 100] - values[n * 16 / 100]), kLeastColorDeviation[i]);
  }
  return color;
}

// Cells within `reach` deviations of the field's median colour.
cv::Mat1b OfColor(const FieldColor& color,
                  const ColorPlanes& colors,
                  const cv::Mat1b& is_seen,
                  double reach) {
  cv::Mat1b same(is_seen.size(), uint8_t{0});
  for (int row = 0; row < same.rows; ++row) {
    for (int col = 0; col < same.cols; ++col) {
      if (!is_seen(row, col)) continue;
      float squares = 0.0f;
      for (size_t i = 0; i < 3; ++i) {
        const float off = (colors[i](row, col) - color.median[i]) / color.deviation[i];
        squares += off * off;
      }
      if (squares < reach * reach) same(row, col) = 255;
    }
  }
  cv::morphologyEx(same, same, cv::MORPH_CLOSE, cv::Mat1b::ones(3, 3));
  // A gap in a hedge does not join two fields.
  cv::morphologyEx(
      same, same, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  return same;
}

// Pieces of `cells` that touch the field.
cv::Mat1b HangingTogether(const cv::Mat1b& cells, const cv::Mat1b& field) {
  cv::Mat1i labels;
  const int num_labels = cv::connectedComponents(cells, labels, 4, CV_32S);
  std::vector<uint8_t> touches(static_cast<size_t>(num_labels), 0);
  for (int row = 0; row < cells.rows; ++row) {
    for (int col = 0; col < cells.cols; ++col) {
      if (field(row, col)) touches[static_cast<size_t>(labels(row, col))] = 255;
    }
  }
  touches[0] = 0;
  cv::Mat1b pieces(cells.size());
  std::transform(labels.begin(), labels.end(), pieces.begin(), [&](int label) {
    return touches[static_cast<size_t>(label)];
  });
  return pieces;
}

}  // namespace

cv::Mat1b WithRestOfField(const cv::Mat1b& sprayed,
                          const Orthophoto& photo,
                          const Grid& grid,
                          const CoverOptions& options) {
  cv::Mat1b whole = sprayed.clone();
  if (cv::countNonZero(sprayed) < kMinNumCells) return whole;
  const ColorsOnMap on_map = ColorsOfMap(photo, grid);
  const double reach_cells = 0.5 * options.max_working_width_m / grid.cell_size_m;
  cv::Mat1i labels;
  const int num_labels = cv::connectedComponents(sprayed, labels, 8, CV_32S);
  for (int label = 1; label < num_labels; ++label) {
    const cv::Mat1b field = labels == label;
    const std::optional<FieldColor> color = ColorOfField(field, on_map.colors, on_map.is_seen);
    if (!color) continue;
    cv::Mat1f distance;
    cv::distanceTransform(field == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    const cv::Mat1b rest =
        (OfColor(*color, on_map.colors, on_map.is_seen, options.max_field_color_deviations) &
         (distance <= reach_cells)) |
        field;
    whole |= HangingTogether(rest, field);
  }
  // The blur leaves a border of mixed colour.
  cv::dilate(whole, whole, cv::Mat1b::ones(3, 3));
  return whole;
}

}  // namespace freelsd
