// Tables of source pixels for resampling an image.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freelsd {

// Table entry without a source pixel: far outside every image.
inline constexpr float kNoPixel = -1e4F;

// Table for cv::remap: source_at(column, row) is exact at every n-th pixel, linear between them.
// Pixels next to a node without a source have none either (kNoPixel).
cv::Mat2f RemapTable(
    const cv::Size& size,
    int node_spacing_px,
    const std::function<std::optional<Eigen::Vector2d>(double, double)>& source_at);

}  // namespace freelsd
