#include "engine/hazard/standing_growth.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// A plane needs this share of its window's cells: fewer lie in a corner or a thread.
constexpr double kMinWindowRatio = 0.18;
// Finer cells are looked at this far apart: the cost would grow with their fourth power.
constexpr double kSampleSpacingM = 1.0;

// Cells that look like grass and hang together without a step.
cv::Mat1b GrassCells(const cv::Mat1f& elevation,
                     const cv::Mat1f& roughness,
                     const cv::Mat1f& grass,
                     const HazardOptions& options) {
  cv::Mat1b cells(grass.size(), uchar{0});
  for (int row = 0; row < grass.rows; ++row) {
    for (int col = 0; col < grass.cols; ++col) {
      // Written so that NaN fails.
      const bool is_member = grass(row, col) >= options.min_grass_posterior &&
                             roughness(row, col) <= options.max_growth_roughness_m &&
                             std::isfinite(elevation(row, col));
      if (is_member) cells(row, col) = 255;
    }
  }
  return cells;
}

// Cells by the piece that they belong to, from 1; 0 where they do not look like grass, or lie in a
// strip too narrow to be anything but an edge. Pieces joined by a strip only are several: a step
// between crop and meadow is seldom seen along all of its length.
cv::Mat1i LabelPieces(const cv::Mat1b& cells, double cell_size_m, const HazardOptions& options) {
  cv::Mat1i label(cells.size(), 0);
  cv::Mat1f to_edge, to_core;
  cv::distanceTransform(cells, to_edge, cv::DIST_L2, cv::DIST_MASK_5);
  const double core_cells = options.min_piece_half_width_m / cell_size_m;
  const cv::Mat1b core = (to_edge >= core_cells) & cells;
  if (cv::countNonZero(core) == 0) return label;
  cv::Mat1i nearest;
  cv::distanceTransform(
      ~core, to_core, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_CCOMP);
  // Corners were worn away by more than the sides.
  const cv::Mat1b is_near = to_core <= std::sqrt(2.0) * core_cells + 1.0;
  nearest.copyTo(label, cells & is_near);
  return label;
}

// Which cells are looked at.
struct Sampling {
  int stride = 1;
  // Of the window about an edge, in strides.
  int reach = 1;
};

Sampling SamplingOf(double cell_size_m, const HazardOptions& options) {
  Sampling sampling;
  sampling.stride = std::max(1, static_cast<int>(std::lround(kSampleSpacingM / cell_size_m)));
  const double spacing_m = sampling.stride * cell_size_m;
  sampling.reach = std::max(1, static_cast<int>(std::lround(options.edge_support_m / spacing_m)));
  return sampling;
}

// Height at a place outside to which the piece goes on, by the plane through its cells near `edge`.
double HeightGoneOn(const cv::Mat1f& elevation,
                    const cv::Mat1i& label,
                    const cv::Point& edge,
                    const cv::Point& place,
                    const Sampling& sampling) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const cv::Rect whole(0, 0, label.cols, label.rows);
  for (int i = -sampling.reach; i <= sampling.reach; ++i) {
    for (int j = -sampling.reach; j <= sampling.reach; ++j) {
      const cv::Point cell = edge + sampling.stride * cv::Point(j, i);
      if (!whole.contains(cell) || label(cell) != label(edge)) continue;
      const Eigen::Vector3d terms(1.0, cell.x - place.x, cell.y - place.y);
      normal += terms * terms.transpose();
      right += terms * static_cast<double>(elevation(cell));
    }
  }
  const double side = 2.0 * sampling.reach + 1.0;
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  // Cells in one line have no plane.
  constexpr double kMinReciprocalCondition = 1e-7;
  if (normal(0, 0) < kMinWindowRatio * side * side || solver.rcond() < kMinReciprocalCondition) {
    return std::nan("");
  }
  return solver.solve(right)[0];
}

// Part of the map around a piece, wide enough for its surroundings.
cv::Rect BoxAround(const cv::Mat1b& piece, double margin_cells) {
  const cv::Rect box = cv::boundingRect(piece);
  const int margin = static_cast<int>(std::ceil(margin_cells)) + 1;
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect(0, 0, piece.cols, piece.rows);
}

// Nearest cell of the piece by the value of the distance transform's labels.
std::vector<cv::Point> CellsByLabel(const cv::Mat1b& piece, const cv::Mat1i& nearest) {
  std::vector<cv::Point> cells(static_cast<size_t>(cv::countNonZero(piece)) + 1);
  for (int row = 0; row < piece.rows; ++row) {
    for (int col = 0; col < piece.cols; ++col) {
      if (piece(row, col) != 0) cells[static_cast<size_t>(nearest(row, col))] = {col, row};
    }
  }
  return cells;
}

// Of one piece; `label` and `elevation` are cut to the box around it.
EdgeLevel LevelOf(const cv::Mat1i& label,
                  int piece_label,
                  const cv::Mat1f& elevation,
                  double cell_size_m,
                  const HazardOptions& options) {
  const cv::Mat1b piece = label == piece_label;
  cv::Mat1f distance;
  cv::Mat1i nearest;
  cv::distanceTransform(
      ~piece, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  const std::vector<cv::Point> cells = CellsByLabel(piece, nearest);
  const Sampling sampling = SamplingOf(cell_size_m, options);
  EdgeLevel level;
  for (int row = 0; row < label.rows; row += sampling.stride) {
    for (int col = 0; col < label.cols; col += sampling.stride) {
      const double metres = distance(row, col) * cell_size_m;
      if (metres < options.min_edge_distance_m || metres > options.max_edge_distance_m) continue;
      if (std::isnan(elevation(row, col))) continue;
      const cv::Point edge = cells[static_cast<size_t>(nearest(row, col))];
      const double step =
          HeightGoneOn(elevation, label, edge, {col, row}, sampling) - elevation(row, col);
      if (std::isnan(step)) continue;
      const bool is_level = std::abs(step) <= options.edge_step_m;
      // Another piece as high as this one may be the same crop beyond a wheel track.
      if (is_level && label(row, col) != 0) continue;
      ++(is_level ? level.num_level : step > 0.0 ? level.num_below : level.num_above);
    }
  }
  return level;
}

}  // namespace

bool EdgeLevel::IsSuspect(const HazardOptions& options) const {
  const int num_telling = num_below + num_level;
  const int num_seen = num_telling + num_above;
  if (num_seen < options.min_num_edge_cells) return false;
  return num_telling < options.min_telling_edge_ratio * num_seen ||
         num_below > options.max_raised_edge_ratio * num_telling;
}

cv::Mat1b FindStandingGrowth(const cv::Mat1f& elevation,
                             const cv::Mat1f& roughness,
                             const cv::Mat1f& grass,
                             double cell_size_m,
                             const HazardOptions& options) {
  cv::Mat1b suspect(grass.size(), uchar{0});
  const cv::Mat1b cells = GrassCells(elevation, roughness, grass, options);
  if (cv::countNonZero(cells) == 0) return suspect;
  const cv::Mat1i label = LabelPieces(cells, cell_size_m, options);
  double num_pieces = 0.0;
  cv::minMaxLoc(label, nullptr, &num_pieces);
  for (int piece = 1; piece <= static_cast<int>(num_pieces); ++piece) {
    const cv::Mat1b mask = label == piece;
    const cv::Rect box = BoxAround(mask, options.max_edge_distance_m / cell_size_m);
    if (LevelOf(label(box), piece, elevation(box), cell_size_m, options).IsSuspect(options)) {
      suspect.setTo(255, mask);
    }
  }
  return suspect;
}

}  // namespace freelsd
