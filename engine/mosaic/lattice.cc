#include "engine/mosaic/lattice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Tolerance for a grid's corner on a multiple of the cell size, in cells.
constexpr double kAlignmentTolerance = 1e-6;
// A pixel may be this much finer than the photographs.
constexpr double kMaxFinenessRatio = 0.03;

double MedianSamplingM(const AdjustedBlock& block) {
  std::vector<double> samplings_m;
  for (const AdjustedView& view : block.views) {
    if (!view.is_connected || !(view.height_above_ground > 0.0)) continue;
    samplings_m.push_back(view.height_above_ground / block.camera.MeanFocalPx());
  }
  if (samplings_m.empty()) return 0.0;
  const auto middle = samplings_m.begin() + static_cast<std::ptrdiff_t>(samplings_m.size() / 2);
  std::nth_element(samplings_m.begin(), middle, samplings_m.end());
  return *middle;
}

int AlignedIndex(double coordinate, double cell_size_m) {
  const double index = coordinate / cell_size_m;
  const double rounded = std::round(index);
  if (!(std::abs(index - rounded) < kAlignmentTolerance)) {
    throw std::invalid_argument("map.grid.north_west_in_world = " + std::to_string(coordinate) +
                                ": must be a multiple of the cell size");
  }
  return static_cast<int>(rounded);
}

}  // namespace

int FloorDivide(int numerator, int positive_denominator) {
  const int quotient = numerator / positive_denominator;
  return quotient - (numerator % positive_denominator < 0 ? 1 : 0);
}

cv::Rect Coarser(const cv::Rect& cells, int factor) {
  const cv::Point first(FloorDivide(cells.x, factor), FloorDivide(cells.y, factor));
  const cv::Point end(-FloorDivide(-(cells.x + cells.width), factor),
                      -FloorDivide(-(cells.y + cells.height), factor));
  return {first, end};
}

cv::Rect Finer(const cv::Rect& cells, int factor) {
  return {cells.x * factor, cells.y * factor, cells.width * factor, cells.height * factor};
}

cv::Rect Widened(const cv::Rect& cells, int margin) {
  return {cells.x - margin, cells.y - margin, cells.width + 2 * margin, cells.height + 2 * margin};
}

cv::Rect PixelsOf(const Grid& grid, double pixel_size_m) {
  const int pixels_per_cell = static_cast<int>(std::lround(grid.cell_size_m / pixel_size_m));
  const int west = AlignedIndex(grid.north_west_in_world.x(), grid.cell_size_m);
  const int north = AlignedIndex(-grid.north_west_in_world.y(), grid.cell_size_m);
  return Finer({west, north, grid.num_cols, grid.num_rows}, pixels_per_cell);
}

int PixelsPerSeamCell(const MosaicLattice& lattice, const MosaicOptions& options) {
  const double wanted = std::log2(options.seam_cell_size_m / lattice.pixel_size_m);
  const int power = std::clamp(static_cast<int>(std::lround(wanted)), 0, 6);
  return std::min(1 << power, lattice.tile_size_px / 4);
}

cv::Mat Part(const cv::Mat& raster, const cv::Rect& given, const cv::Rect& wanted) {
  const cv::Rect common = given & wanted;
  if (common.area() == 0) return {};
  cv::Mat part;
  cv::copyMakeBorder(raster(common - given.tl()),
                     part,
                     common.y - wanted.y,
                     wanted.br().y - common.br().y,
                     common.x - wanted.x,
                     wanted.br().x - common.br().x,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  return part;
}

cv::Mat Refined(const cv::Mat& raster, const cv::Rect& coarse, int factor, const cv::Rect& fine) {
  const cv::Rect around = Widened(Coarser(fine, factor), 1);
  const cv::Mat part = Part(raster, coarse, around);
  if (part.empty()) return {};
  cv::Mat refined;
  cv::resize(part, refined, part.size() * factor, 0.0, 0.0, cv::INTER_LINEAR);
  return refined(fine - Finer(around, factor).tl());
}

cv::Rect MosaicLattice::TilesOf(int level) const { return Coarser(tiles, 1 << level); }

MosaicLattice PlanMosaic(const ElevationMap& map,
                         const AdjustedBlock& block,
                         const MosaicOptions& options) {
  options.Check();
  MosaicLattice lattice;
  const double sampling_m = MedianSamplingM(block);
  if (map.elevation.empty() || sampling_m == 0.0) return lattice;
  const double cell_size_m = map.grid.cell_size_m;
  const double finest_m =
      std::max(options.min_pixel_size_m, sampling_m * (1.0 - kMaxFinenessRatio));
  const double pixels_per_cell =
      std::max(1.0, std::floor(cell_size_m / finest_m + kAlignmentTolerance));
  lattice.pixel_size_m = cell_size_m / pixels_per_cell;
  lattice.tile_size_px = options.tile_size_px;
  const cv::Rect pixels = PixelsOf(map.grid, lattice.pixel_size_m);
  lattice.tiles = Coarser(pixels, lattice.tile_size_px);
  lattice.num_levels = 1;
  const int side_px = std::max(pixels.width, pixels.height);
  while ((lattice.tile_size_px << (lattice.num_levels - 1)) < side_px) ++lattice.num_levels;
  return lattice;
}

}  // namespace freelsd
