#include "engine/hazard/standing_growth.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// A plane needs this share of its window's cells: fewer lie in a corner or a thread.
constexpr double kMinWindowRatio = 0.18;
// Finer cells are looked at this far apart: the cost would grow with their fourth power.
constexpr double kSampleSpacingM = 1.0;
// So near to a step it is blurred.
constexpr double kStepWidthM = 1.0;

// Weights of the height step across a line through the middle of a window, at right angles to
// `direction`: least squares of two planes of the same slope, one on either side.
cv::Mat1f StepKernel(const cv::Point2d& direction, double reach_m, double cell_size_m) {
  const int reach = std::max(2, static_cast<int>(std::lround(reach_m / cell_size_m)));
  std::vector<cv::Point> cells;
  std::vector<Eigen::RowVector4d> terms;
  for (int row = -reach; row <= reach; ++row) {
    for (int col = -reach; col <= reach; ++col) {
      const double across = (direction.x * col + direction.y * row) * cell_size_m;
      const bool is_in_window = row * row + col * col <= reach * reach;
      if (!is_in_window || std::abs(across) < kStepWidthM) continue;
      cells.emplace_back(col, row);
      terms.emplace_back(across > 0.0, across < 0.0, col, row);
    }
  }
  Eigen::MatrixX4d design(terms.size(), 4);
  for (size_t i = 0; i < terms.size(); ++i) design.row(static_cast<long>(i)) = terms[i];
  const Eigen::Matrix4d inverse = (design.transpose() * design).inverse();
  const Eigen::VectorXd weights = design * (inverse.col(0) - inverse.col(1));
  cv::Mat1f kernel(2 * reach + 1, 2 * reach + 1, 0.0F);
  for (size_t i = 0; i < cells.size(); ++i) {
    kernel(cells[i] + cv::Point(reach, reach)) = static_cast<float>(weights[static_cast<long>(i)]);
  }
  return kernel;
}

// Unseen cells take the height of the nearest one seen.
cv::Mat1f Filled(const cv::Mat1f& elevation) {
  cv::Mat1b is_unseen(elevation.size());
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      is_unseen(row, col) = std::isnan(elevation(row, col));
    }
  }
  cv::Mat1f distance;
  cv::Mat1i nearest;
  cv::distanceTransform(
      is_unseen, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<float> height(static_cast<size_t>(elevation.total()) + 1, 0.0F);
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      if (is_unseen(row, col) == 0) {
        height[static_cast<size_t>(nearest(row, col))] = elevation(row, col);
      }
    }
  }
  cv::Mat1f filled(elevation.size());
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      filled(row, col) = height[static_cast<size_t>(nearest(row, col))];
    }
  }
  return filled;
}

// The largest height step across any of four lines through each cell.
cv::Mat1f StepOf(const cv::Mat1f& elevation, double reach_m, double cell_size_m) {
  const cv::Mat1f filled = Filled(elevation);
  cv::Mat1f largest(elevation.size(), 0.0F);
  for (const cv::Point2d& direction : {cv::Point2d(1.0, 0.0),
                                       cv::Point2d(0.0, 1.0),
                                       cv::Point2d(M_SQRT1_2, M_SQRT1_2),
                                       cv::Point2d(M_SQRT1_2, -M_SQRT1_2)}) {
    cv::Mat1f step;
    cv::filter2D(filled,
                 step,
                 CV_32F,
                 StepKernel(direction, reach_m, cell_size_m),
                 cv::Point(-1, -1),
                 0.0,
                 cv::BORDER_REPLICATE);
    largest = cv::max(largest, cv::Mat1f(cv::abs(step)));
  }
  return largest;
}

// Cells that look like grass.
cv::Mat1b GrassCells(const cv::Mat1f& elevation,
                     const cv::Mat1f& grass,
                     const HazardOptions& options) {
  cv::Mat1b cells(grass.size(), uchar{0});
  for (int row = 0; row < grass.rows; ++row) {
    for (int col = 0; col < grass.cols; ++col) {
      // Written so that NaN fails.
      const bool is_member =
          grass(row, col) >= options.min_grass_posterior && std::isfinite(elevation(row, col));
      if (is_member) cells(row, col) = 255;
    }
  }
  return cells;
}

// Cells by the piece that they belong to, from 1; 0 where they do not look like grass, or lie in a
// strip too narrow to be anything but an edge.
struct Pieces {
  cv::Mat1i all;
  // Without the step around them, which the map shows as a broad band.
  cv::Mat1i inner;
};

// A piece grows from a core without a step; the band is shared by the cores on either side.
Pieces LabelPieces(const cv::Mat1b& cells,
                   const cv::Mat1f& step,
                   double cell_size_m,
                   const HazardOptions& options) {
  Pieces pieces{cv::Mat1i(cells.size(), 0), cv::Mat1i(cells.size(), 0)};
  const cv::Mat1b is_level = cells & (step <= options.edge_step_m);
  const double half_band_m = 0.5 * options.edge_support_m;
  const double core_m = std::max(cell_size_m, options.min_piece_half_width_m - half_band_m);
  cv::Mat1f to_edge, to_core;
  cv::distanceTransform(is_level, to_edge, cv::DIST_L2, cv::DIST_MASK_5);
  const cv::Mat1b core = (to_edge >= core_m / cell_size_m) & is_level;
  if (cv::countNonZero(core) == 0) return pieces;
  cv::Mat1i nearest;
  cv::distanceTransform(
      ~core, to_core, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_CCOMP);
  // Corners were worn away by more than the sides.
  const double reach_m = std::sqrt(2.0) * (options.min_piece_half_width_m + half_band_m);
  const cv::Mat1b is_near = to_core <= reach_m / cell_size_m + 1.0;
  nearest.copyTo(pieces.all, cells & is_near);
  nearest.copyTo(pieces.inner, is_level & is_near);
  return pieces;
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

// Of one piece, within the box around it.
EdgeLevel LevelOf(const Pieces& pieces,
                  int piece_label,
                  const cv::Rect& box,
                  const cv::Mat1f& elevation,
                  double cell_size_m,
                  const HazardOptions& options) {
  const cv::Mat1i all = pieces.all(box), inner = pieces.inner(box);
  const cv::Mat1f height = elevation(box);
  const cv::Mat1b piece = inner == piece_label;
  cv::Mat1f distance;
  cv::Mat1i nearest;
  cv::distanceTransform(
      ~piece, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  const std::vector<cv::Point> cells = CellsByLabel(piece, nearest);
  const Sampling sampling = SamplingOf(cell_size_m, options);
  EdgeLevel level;
  for (int row = 0; row < box.height; row += sampling.stride) {
    for (int col = 0; col < box.width; col += sampling.stride) {
      const double metres = distance(row, col) * cell_size_m;
      if (metres < options.min_edge_distance_m || metres > options.max_edge_distance_m) continue;
      if (all(row, col) == piece_label || std::isnan(height(row, col))) continue;
      const cv::Point edge = cells[static_cast<size_t>(nearest(row, col))];
      const double step =
          HeightGoneOn(height, inner, edge, {col, row}, sampling) - height(row, col);
      if (std::isnan(step)) continue;
      const bool is_level = std::abs(step) <= options.edge_step_m;
      // Another piece as high as this one may be the same crop beyond a wheel track.
      if (is_level && all(row, col) != 0) continue;
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
                             const cv::Mat1f& grass,
                             double cell_size_m,
                             const HazardOptions& options) {
  cv::Mat1b suspect(grass.size(), uchar{0});
  const bool is_off = options.max_raised_edge_ratio >= 1.0 && options.min_telling_edge_ratio <= 0.0;
  if (is_off) return suspect;
  const cv::Mat1b cells = GrassCells(elevation, grass, options);
  if (cv::countNonZero(cells) == 0) return suspect;
  const cv::Mat1f step = StepOf(elevation, options.edge_support_m, cell_size_m);
  const Pieces pieces = LabelPieces(cells, step, cell_size_m, options);
  double num_pieces = 0.0;
  cv::minMaxLoc(pieces.all, nullptr, &num_pieces);
  for (int piece = 1; piece <= static_cast<int>(num_pieces); ++piece) {
    const cv::Mat1b mask = pieces.all == piece;
    const cv::Rect box = BoxAround(mask, options.max_edge_distance_m / cell_size_m);
    const EdgeLevel level = LevelOf(pieces, piece, box, elevation, cell_size_m, options);
    if (level.IsSuspect(options)) suspect.setTo(255, mask);
  }
  return suspect;
}

}  // namespace freelsd
