#include "engine/terrain/surface.h"

#include <cmath>
#include <random>

#include <Eigen/Eigenvalues>
#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("surface: the closed form of the nine-cell PCA agrees with the eigen-solver to 1e-9") {
  constexpr double kSameAngle = 1e-9;
  std::mt19937 random(17);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  for (int i = 0; i < 2000; ++i) {
    const double cell = i % 2 == 0 ? 1.0 : 0.3;
    const double steepness = 3.0 * uniform(), aspect = 6.0 * uniform(), noise = 0.3 * uniform();
    std::array<double, 9> heights{};
    Eigen::Matrix<double, 3, 9> points;
    for (int k = 0; k < 9; ++k) {
      const int row = k / 3, column = k % 3;
      const double x = cell * (column - 1), y = -cell * (row - 1);
      const double z =
          200.0 + steepness * (x * std::cos(aspect) + y * std::sin(aspect)) + noise * uniform();
      heights[static_cast<size_t>(k)] = z - 200.0;
      points.col(k) << x, y, z - 200.0;
    }
    const Eigen::Matrix<double, 3, 9> centered = points.colwise() - points.rowwise().mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(centered * centered.transpose());
    const Eigen::Vector3d normal = solver.eigenvectors().col(0);
    const double slope = std::atan2(normal.head<2>().norm(), std::abs(normal.z()));
    CHECK(std::abs(PcaSlopeOf(heights, cell) - slope) < kSameAngle);
  }
  CHECK(PcaSlopeOf({}, 1.0) == 0.0);
}

}  // namespace
}  // namespace freelsd
