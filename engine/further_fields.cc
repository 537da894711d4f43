#include "engine/further_fields.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Cells of the region on which the touchdown disc fits: 255, else 0.
cv::Mat1b WideGround(const Region& region, const HazardLayers& hazards, double required_distance) {
  cv::Mat1b is_wide = cv::Mat1b::zeros(hazards.distance.size());
  const Polygon footprint = region.Footprint();
  for (int row = 0; row < is_wide.rows; ++row) {
    for (int col = 0; col < is_wide.cols; ++col) {
      if (!(hazards.distance(row, col) >= required_distance)) continue;
      if (Contains(footprint, hazards.grid.CellCenter(row, col))) is_wide(row, col) = 255;
    }
  }
  return is_wide;
}

// The rectangle around a piece with the discs of its touchdowns.
Region Around(const cv::Mat1b& is_piece,
              const Region& region,
              const Evaluation& evaluation,
              double margin) {
  Polygon outline;
  double height = 0.0;
  int num_cells = 0;
  for (int row = 0; row < is_piece.rows; ++row) {
    for (int col = 0; col < is_piece.cols; ++col) {
      if (!is_piece(row, col)) continue;
      const Eigen::Vector2d center = evaluation.hazards.grid.CellCenter(row, col);
      for (const double east : {-margin, margin}) {
        for (const double north : {-margin, margin}) {
          outline.push_back(center + Eigen::Vector2d(east, north));
        }
      }
      height += evaluation.map.elevation(row, col);
      ++num_cells;
    }
  }
  Region field = region;
  field.corners_in_world.clear();
  for (const Eigen::Vector2d& corner : MinAreaRectangle(outline)) {
    field.corners_in_world.emplace_back(corner.x(), corner.y(), height / num_cells);
  }
  field.area_m2 = Area(field.Footprint());
  return field;
}

}  // namespace

std::vector<Region> FurtherFields(const Region& region,
                                  const Eigen::Vector2d& taken,
                                  const Evaluation& evaluation,
                                  double required_hazard_distance,
                                  int max_num_fields) {
  if (evaluation.hazards.distance.empty()) return {};
  cv::Mat labels, stats, centers;
  const int num_labels = cv::connectedComponentsWithStats(
      WideGround(region, evaluation.hazards, required_hazard_distance), labels, stats, centers);
  const std::optional<cv::Point> taken_cell = evaluation.hazards.grid.CellAt(taken);
  std::vector<int> pieces;
  for (int label = 1; label < num_labels; ++label) {
    if (!taken_cell || labels.at<int>(*taken_cell) != label) pieces.push_back(label);
  }
  std::stable_sort(pieces.begin(), pieces.end(), [&](int a, int b) {
    return stats.at<int>(a, cv::CC_STAT_AREA) > stats.at<int>(b, cv::CC_STAT_AREA);
  });
  std::vector<Region> fields;
  for (const int label : pieces) {
    if (fields.size() >= static_cast<size_t>(max_num_fields)) break;
    fields.push_back(Around(labels == label, region, evaluation, required_hazard_distance));
  }
  return fields;
}

}  // namespace freelsd
