#include "engine/hazard/surface.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Sums over cells of a window; x east and y south in cells, from the window's centre.
struct Moments {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  double z = 0.0, xz = 0.0, yz = 0.0;
};

// Moments of one column of the window, x not yet known.
struct ColumnMoments {
  double n = 0.0, y = 0.0, yy = 0.0, z = 0.0, yz = 0.0;
};

// Of the rows [row - reach, row + reach] of every column; heights relative to base_height.
std::vector<ColumnMoments> ColumnsAround(const cv::Mat1f& elevation,
                                         int row,
                                         int reach,
                                         double base_height) {
  std::vector<ColumnMoments> columns(elevation.cols);
  for (int r = std::max(0, row - reach); r <= std::min(elevation.rows - 1, row + reach); ++r) {
    const float* line = elevation[r];
    const double y = r - row;
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(line[col])) continue;
      const double z = line[col] - base_height;
      ColumnMoments& column = columns[col];
      column.n += 1.0;
      column.y += y;
      column.yy += y * y;
      column.z += z;
      column.yz += y * z;
    }
  }
  return columns;
}

Moments WindowAround(const std::vector<ColumnMoments>& columns, int col, int reach) {
  Moments m;
  const int last = std::min(static_cast<int>(columns.size()) - 1, col + reach);
  for (int c = std::max(0, col - reach); c <= last; ++c) {
    const ColumnMoments& column = columns[c];
    const double x = c - col;
    m.n += column.n;
    m.x += x * column.n;
    m.y += column.y;
    m.xx += x * x * column.n;
    m.xy += x * column.y;
    m.yy += column.yy;
    m.z += column.z;
    m.xz += x * column.z;
    m.yz += column.yz;
  }
  return m;
}

// Slope of the least-squares plane; NaN where the cells lie on a line.
float SlopeOf(const Moments& m, double cell_size_m) {
  const double xx = m.xx - m.x * m.x / m.n;
  const double xy = m.xy - m.x * m.y / m.n;
  const double yy = m.yy - m.y * m.y / m.n;
  const double xz = m.xz - m.x * m.z / m.n;
  const double yz = m.yz - m.y * m.z / m.n;
  const double determinant = xx * yy - xy * xy;
  // In cells^4; a 2 x 2 block has 1.
  constexpr double kMinDeterminant = 0.5;
  if (!(determinant >= kMinDeterminant)) return kNaN;
  const double east = (xz * yy - yz * xy) / determinant;
  const double south = (yz * xx - xz * xy) / determinant;
  return static_cast<float>(std::atan(std::hypot(east, south) / cell_size_m));
}

// Seen cells of the 3x3 neighbourhood, metres, relative to its centre.
Eigen::Matrix3Xd Neighbourhood(const cv::Mat1f& elevation, int row, int col, double cell_size_m) {
  Eigen::Matrix3Xd points(3, 9);
  int count = 0;
  for (int r = std::max(0, row - 1); r <= std::min(elevation.rows - 1, row + 1); ++r) {
    for (int c = std::max(0, col - 1); c <= std::min(elevation.cols - 1, col + 1); ++c) {
      if (std::isnan(elevation(r, c))) continue;
      const double height = static_cast<double>(elevation(r, c)) - elevation(row, col);
      points.col(count++) << (c - col) * cell_size_m, (row - r) * cell_size_m, height;
    }
  }
  return points.leftCols(count);
}

// Angle of the normal (axis of least variance) to the vertical.
float PcaSlopeOf(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centered = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3d covariance = centered * centered.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const double cosine = std::abs(solver.eigenvectors()(2, 0));
  return static_cast<float>(std::acos(std::min(1.0, cosine)));
}

}  // namespace

cv::Mat1f TrustedElevation(const ElevationMap& map, double max_standard_deviation_m) {
  cv::Mat1f trusted = map.elevation.clone();
  for (int row = 0; row < trusted.rows; ++row) {
    for (int col = 0; col < trusted.cols; ++col) {
      const bool is_trusted = std::isfinite(trusted(row, col)) &&
                              map.standard_deviation(row, col) <= max_standard_deviation_m;
      if (!is_trusted) trusted(row, col) = kNaN;
    }
  }
  return trusted;
}

cv::Mat1f PlaneSlope(const cv::Mat1f& elevation, double cell_size_m, const HazardOptions& options) {
  cv::Mat1f slope(elevation.size(), kNaN);
  // A support of 9 m is 9 cells of 1 m: 4 to each side; at least the 3x3 neighbourhood.
  const int reach = std::max(1, static_cast<int>(options.plane_support_m / cell_size_m / 2.0));
  const double min_num_cells = options.min_support_ratio * (2 * reach + 1) * (2 * reach + 1);
  double base_height = kNaN;
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols && std::isnan(base_height); ++col) {
      base_height = elevation(row, col);
    }
  }
  for (int row = 0; row < elevation.rows; ++row) {
    const std::vector<ColumnMoments> columns = ColumnsAround(elevation, row, reach, base_height);
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(elevation(row, col))) continue;
      const Moments moments = WindowAround(columns, col, reach);
      if (moments.n >= min_num_cells) slope(row, col) = SlopeOf(moments, cell_size_m);
    }
  }
  return slope;
}

cv::Mat1f PaperPcaSlope(const cv::Mat1f& elevation,
                        double cell_size_m,
                        const HazardOptions& options) {
  cv::Mat1f slope(elevation.size(), kNaN);
  constexpr double kNumCells = 9.0;
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(elevation(row, col))) continue;
      const Eigen::Matrix3Xd points = Neighbourhood(elevation, row, col, cell_size_m);
      const bool is_supported = points.cols() >= options.min_support_ratio * kNumCells;
      if (is_supported) slope(row, col) = PcaSlopeOf(points);
    }
  }
  return slope;
}

cv::Mat1f Ruggedness(const cv::Mat1f& elevation, int spacing) {
  cv::Mat1f roughness(elevation.size(), kNaN);
  for (int row = spacing; row < elevation.rows - spacing; ++row) {
    for (int col = spacing; col < elevation.cols - spacing; ++col) {
      // An unseen cell is NaN, and so is every sum it enters.
      double sum = 0.0;
      for (int dr = -spacing; dr <= spacing; dr += spacing) {
        for (int dc = -spacing; dc <= spacing; dc += spacing) {
          const double step =
              static_cast<double>(elevation(row + dr, col + dc)) - elevation(row, col);
          sum += step * step;
        }
      }
      roughness(row, col) = static_cast<float>(std::sqrt(sum));
    }
  }
  return roughness;
}

}  // namespace freelsd
