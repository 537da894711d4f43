#include "tests/evaluation/fields/outline_agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/evaluation/fields/outline_masks.h"

namespace freelsd {
namespace {

constexpr double kSampleSpacingM = 0.5;

double DistanceToEdge(const Eigen::Vector2d& point,
                      const Eigen::Vector2d& from,
                      const Eigen::Vector2d& to) {
  const Eigen::Vector2d edge = to - from;
  const double length = std::max(edge.squaredNorm(), 1e-12);
  const double share = std::clamp((point - from).dot(edge) / length, 0.0, 1.0);
  return (from + share * edge - point).norm();
}

double DistanceToBorder(const Eigen::Vector2d& point, const Polygon& polygon) {
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < polygon.size(); ++i) {
    distance =
        std::min(distance, DistanceToEdge(point, polygon[i], polygon[(i + 1) % polygon.size()]));
  }
  return distance;
}

double MeanDistanceFrom(const Polygon& a, const Polygon& b) {
  double sum = 0.0;
  int count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d edge = a[(i + 1) % a.size()] - a[i];
    const int num_samples = std::max(1, static_cast<int>(edge.norm() / kSampleSpacingM));
    for (int sample = 0; sample < num_samples; ++sample, ++count) {
      sum += DistanceToBorder(a[i] + edge * (double(sample) / num_samples), b);
    }
  }
  return sum / count;
}

double OverlapOf(const GroundOutline& a, const GroundOutline& b, const Grid& grid) {
  const cv::Mat1b in_a = MaskOf(a.outline, grid), in_b = MaskOf(b.outline, grid);
  return double(cv::countNonZero(in_a & in_b)) / std::max(1, cv::countNonZero(in_a | in_b));
}

}  // namespace

double MeanBorderDistance(const Polygon& a, const Polygon& b) {
  return 0.5 * (MeanDistanceFrom(a, b) + MeanDistanceFrom(b, a));
}

Disagreement DisagreementOf(const std::vector<LabelledObject>& objects,
                            const Grid& grid,
                            Tallness tallness) {
  std::vector<double> distances, overlaps;
  for (const LabelledObject& object : objects) {
    if ((object.height_m > kMaxLowHeightM) != (tallness == Tallness::kTall)) continue;
    for (size_t i = 0; i < object.views.size(); ++i) {
      for (size_t j = i + 1; j < object.views.size(); ++j) {
        const GroundOutline &a = object.views[i], &b = object.views[j];
        distances.push_back(MeanBorderDistance(a.outline, b.outline));
        if (IsGround(object.kind)) overlaps.push_back(OverlapOf(a, b, grid));
      }
    }
  }
  Disagreement result;
  if (distances.empty()) return result;
  std::sort(distances.begin(), distances.end());
  result.num_pairs = static_cast<int>(distances.size());
  result.median_m = distances[distances.size() / 2];
  result.largest_m = distances.back();
  for (const double overlap : overlaps) {
    result.mean_overlap_ratio += overlap / static_cast<double>(overlaps.size());
  }
  return result;
}

}  // namespace freelsd
