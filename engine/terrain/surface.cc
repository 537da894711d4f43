#include "engine/terrain/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>

#include "engine/check/check.h"

namespace freelsd {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Sums over the cells of a window; x east and y south in cells, from the window's centre.
struct Moments {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  double z = 0.0, xz = 0.0, yz = 0.0;
};

// Arrays over the map's columns, widened by the window's reach on both sides, so that many windows
// are summed at once.
using Columns = Eigen::ArrayXd;

// Moments of each column of the window, before x is known.
struct ColumnMoments {
  explicit ColumnMoments(Eigen::Index size) { n = y = yy = z = yz = Columns::Zero(size); }
  Columns n, y, yy, z, yz;
};

struct WindowMoments {
  explicit WindowMoments(Eigen::Index size) {
    n = x = y = xx = xy = yy = z = xz = yz = Columns::Zero(size);
  }
  Moments At(Eigen::Index i) const {
    return {n[i], x[i], y[i], xx[i], xy[i], yy[i], z[i], xz[i], yz[i]};
  }
  Columns n, x, y, xx, xy, yy, z, xz, yz;
};

// Over rows [row - reach, row + reach]; heights relative to base_height.
ColumnMoments ColumnsAround(const cv::Mat1f& elevation, int row, int reach, double base_height) {
  ColumnMoments columns(elevation.cols + 2 * reach);
  Columns is_seen = columns.n, height = columns.n;
  for (int r = std::max(0, row - reach); r <= std::min(elevation.rows - 1, row + reach); ++r) {
    const float* line = elevation[r];
    for (int col = 0; col < elevation.cols; ++col) {
      const bool is_number = line[col] == line[col];
      is_seen[col + reach] = is_number ? 1.0 : 0.0;
      height[col + reach] = is_number ? line[col] - base_height : 0.0;
    }
    const double y = r - row;
    columns.n += is_seen;
    columns.y += y * is_seen;
    columns.yy += y * y * is_seen;
    columns.z += height;
    columns.yz += y * height;
  }
  return columns;
}

WindowMoments WindowsAround(const ColumnMoments& columns, int num_cols, int reach) {
  WindowMoments m(num_cols);
  for (int offset = -reach; offset <= reach; ++offset) {
    const auto beside = [&](const Columns& of_column) {
      return of_column.segment(reach + offset, num_cols);
    };
    const double x = offset;
    m.n += beside(columns.n);
    m.x += x * beside(columns.n);
    m.y += beside(columns.y);
    m.xx += x * x * beside(columns.n);
    m.xy += x * beside(columns.y);
    m.yy += beside(columns.yy);
    m.z += beside(columns.z);
    m.xz += x * beside(columns.z);
    m.yz += beside(columns.yz);
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
  return static_cast<float>(std::atan(std::sqrt(east * east + south * south) / cell_size_m));
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

// Heights of the 3x3 neighbourhood relative to its centre, row by row; nothing if one is unseen.
std::optional<std::array<double, 9>> WholeNeighbourhood(const cv::Mat1f& elevation,
                                                        int row,
                                                        int col) {
  if (row < 1 || col < 1 || row + 1 >= elevation.rows || col + 1 >= elevation.cols) {
    return std::nullopt;
  }
  std::array<double, 9> heights{};
  double sum = 0.0;
  for (int i = 0; i < 9; ++i) {
    const double height = elevation(row + i / 3 - 1, col + i % 3 - 1);
    heights[static_cast<size_t>(i)] = height - elevation(row, col);
    sum += height;
  }
  // NaN if one of the heights is NaN.
  if (std::isnan(sum)) return std::nullopt;
  return heights;
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

// x and y are uncorrelated and have equal variance. The covariance then acts in one vertical plane,
// along the steepest ascent, and gives twice the angle of its axes.
double PcaSlopeOf(const std::array<double, 9>& heights, double cell_size_m) {
  double sum = 0.0, squares = 0.0, east = 0.0, south = 0.0;
  for (int i = 0; i < 9; ++i) {
    const double height = heights[static_cast<size_t>(i)];
    sum += height;
    squares += height * height;
    const int row = i / 3, col = i % 3;
    east += (col - 1) * height;
    south += (row - 1) * height;
  }
  const double level_variance = 6.0 * cell_size_m * cell_size_m;
  const double height_variance = squares - sum * sum / 9.0;
  const double covariance = cell_size_m * std::sqrt(east * east + south * south);
  return 0.5 * std::atan2(2.0 * covariance, level_variance - height_variance);
}

cv::Mat1f PlaneSlope(const cv::Mat1f& elevation,
                     double cell_size_m,
                     const SurfaceOptions& options) {
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
    const WindowMoments windows =
        WindowsAround(ColumnsAround(elevation, row, reach, base_height), elevation.cols, reach);
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(elevation(row, col)) || windows.n[col] < min_num_cells) continue;
      slope(row, col) = SlopeOf(windows.At(col), cell_size_m);
    }
  }
  return slope;
}

cv::Mat1f PaperPcaSlope(const cv::Mat1f& elevation,
                        double cell_size_m,
                        const SurfaceOptions& options) {
  cv::Mat1f slope(elevation.size(), kNaN);
  constexpr double kNumCells = 9.0;
  for (int row = 0; row < elevation.rows; ++row) {
    for (int col = 0; col < elevation.cols; ++col) {
      if (std::isnan(elevation(row, col))) continue;
      if (const auto heights = WholeNeighbourhood(elevation, row, col)) {
        slope(row, col) = static_cast<float>(PcaSlopeOf(*heights, cell_size_m));
        continue;
      }
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
      // Unseen cells are NaN, so every sum over them is NaN.
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

void SurfaceOptions::Check() const {
  const FieldCheck check("hazard");
  check.Inside("plane_support_m", plane_support_m, 0.1, 100.0);
  check.Inside("min_support_ratio", min_support_ratio, 0.4, 1.0);
  check.Inside("roughness_spacing_m", roughness_spacing_m, 0.05, 100.0);
  check.Inside("max_standard_deviation_m", max_standard_deviation_m, 0.01, 100.0);
}

GroundSurface MeasureSurface(const ElevationMap& map, const SurfaceOptions& options) {
  options.Check();
  const double cell_size_m = map.grid.cell_size_m;
  const int spacing =
      std::max(1, static_cast<int>(std::lround(options.roughness_spacing_m / cell_size_m)));
  GroundSurface surface;
  surface.elevation = TrustedElevation(map, options.max_standard_deviation_m);
  surface.slope = options.slope_support == SlopeSupport::kPlane
                      ? PlaneSlope(surface.elevation, cell_size_m, options)
                      : PaperPcaSlope(surface.elevation, cell_size_m, options);
  surface.roughness = Ruggedness(surface.elevation, spacing);
  return surface;
}

}  // namespace freelsd
