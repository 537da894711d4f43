// Tables that give the source pixel of each pixel of a resampled image.
#pragma once

#include <functional>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace freelsd {

// Marks a table entry without a source pixel: a coordinate far outside every image.
inline constexpr float kNoPixel = -1e4F;

// Table for cv::remap. Values of source_at(column, row) are exact at nodes, which are
// node_spacing_px apart, and linearly interpolated between them. Pixels beside a node without a
// source are kNoPixel.
cv::Mat2f RemapTable(
    const cv::Size& size,
    int node_spacing_px,
    const std::function<std::optional<Eigen::Vector2d>(double, double)>& source_at);

}  // namespace freelsd
