#include "tests/synthetic/height_field.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr int kFinestSide = 4;
constexpr int kNumLevels = 8;  // up to 512 cells
// A range is read from the finest level at which it spans no more blocks along an axis.
constexpr int kMaxBlocksAcross = 4;
// The footprint of many rays and the heights within it narrow each other down.
constexpr int kMaxNarrowings = 6;
constexpr float kWorthwhileRatio = 0.85f;
// A single ray crosses empty air by blocks of so many cells.
constexpr int kBlockSide = 8;
// Bilinear heights reach one cell beyond the block, and rays are followed half a cell beyond.
constexpr int kBlockMargin = 2;
// Where the ray is below a block's top it is tried every half cell, then the hit is closed in on.
constexpr float kStepCells = 0.5f;
constexpr int kMaxRefinements = 4;
// Of what is missing sideways a pixel from 100 m shows a hundredth.
constexpr float kCloseM = 0.002f;
// Keeps what is divided by a slide finite: a ray that moves less is straight down.
constexpr float kMinSlide = 1e-6f;

// Lowest or highest of 2 x 2; the last row and column stand alone where the number is odd.
template <typename Pick>
cv::Mat1f Halved(const cv::Mat1f& grid, Pick pick) {
  cv::Mat1f half((grid.rows + 1) / 2, (grid.cols + 1) / 2);
  for (int row = 0; row < half.rows; ++row) {
    const float* a = grid[2 * row];
    const float* b = grid[std::min(2 * row + 1, grid.rows - 1)];
    for (int col = 0; col < half.cols; ++col) {
      const int left = 2 * col, right = std::min(2 * col + 1, grid.cols - 1);
      half(row, col) = pick(pick(a[left], a[right]), pick(b[left], b[right]));
    }
  }
  return half;
}

float Lower(float a, float b) { return std::min(a, b); }
float Higher(float a, float b) { return std::max(a, b); }

// Cells that bilinear heights over the box depend on.
cv::Rect CellsUnder(const Eigen::AlignedBox2d& box, const cv::Size& size) {
  const auto index = [](double cell, int num) {
    return static_cast<int>(std::clamp(std::floor(cell), 0.0, num - 1.0));
  };
  const cv::Point first(index(box.min().x() - 1.0, size.width),
                        index(box.min().y() - 1.0, size.height));
  const cv::Point last(index(box.max().x() + 2.0, size.width),
                       index(box.max().y() + 2.0, size.height));
  return {first, last + cv::Point(1, 1)};
}

cv::Mat1f BlockTops(const cv::Mat1f& surface) {
  const int side = kBlockSide;
  cv::Mat1f tops((surface.rows + side - 1) / side, (surface.cols + side - 1) / side);
  for (int row = 0; row < tops.rows; ++row) {
    for (int col = 0; col < tops.cols; ++col) {
      const cv::Rect block(col * side - kBlockMargin,
                           row * side - kBlockMargin,
                           side + 2 * kBlockMargin,
                           side + 2 * kBlockMargin);
      const cv::Rect cells = block & cv::Rect(0, 0, surface.cols, surface.rows);
      float top = surface(cells.y, cells.x);
      for (int y = cells.y; y < cells.br().y; ++y) {
        const float* line = surface[y];
        for (int x = cells.x; x < cells.br().x; ++x) top = std::max(top, line[x]);
      }
      tops(row, col) = top;
    }
  }
  return tops;
}

// Metres of descent per cell along one axis.
float DescentPerCell(float slide) {
  return 1.0f / (std::abs(slide) < kMinSlide ? kMinSlide : slide);
}

}  // namespace

DescentRay DescentThrough(const HeightRange& layer,
                          const Eigen::Vector3d& origin,
                          const Eigen::Vector2d& slide) {
  DescentRay ray;
  ray.top = layer.top;
  ray.limit = layer.top - layer.bottom;
  ray.entry = (origin.head<2>() + (origin.z() - layer.top) * slide).cast<float>();
  ray.slide = slide.cast<float>();
  return ray;
}

HeightField::HeightField(const cv::Mat1f& surface)
    : surface_(surface), block_top_(BlockTops(surface)) {
  Level level{1, surface, surface};
  while (static_cast<int>(levels_.size()) < kNumLevels) {
    level = {2 * level.side, Halved(level.bottom, Lower), Halved(level.top, Higher)};
    if (level.side >= kFinestSide) levels_.push_back(level);
  }
  all_ = RangeIn({0, 0, surface.cols, surface.rows});
}

HeightRange HeightField::RangeIn(const cv::Rect& cells) const {
  const int extent = std::max(cells.width, cells.height);
  size_t i = 0;
  while (i + 1 < levels_.size() && (kMaxBlocksAcross - 1) * levels_[i].side < extent) ++i;
  const Level& level = levels_[i];
  const cv::Point first = cells.tl() / level.side;
  const cv::Point last = (cells.br() - cv::Point(1, 1)) / level.side;
  HeightRange range{level.bottom(first), level.top(first)};
  for (int row = first.y; row <= last.y; ++row) {
    for (int col = first.x; col <= last.x; ++col) {
      range.bottom = std::min(range.bottom, level.bottom(row, col));
      range.top = std::max(range.top, level.top(row, col));
    }
  }
  return range;
}

HeightRange HeightField::LayerMetBy(const Eigen::Vector3d& origin,
                                    const Eigen::AlignedBox2d& slides) const {
  const float ceiling = static_cast<float>(origin.z());
  HeightRange layer{std::min(all_.bottom, ceiling), std::min(all_.top, ceiling)};
  for (int i = 0; i < kMaxNarrowings; ++i) {
    Eigen::AlignedBox2d footprint;
    for (const double depth : {origin.z() - layer.top, origin.z() - layer.bottom}) {
      footprint.extend(origin.head<2>() + depth * slides.min());
      footprint.extend(origin.head<2>() + depth * slides.max());
    }
    const HeightRange met = RangeIn(CellsUnder(footprint, surface_.size()));
    const float height = layer.top - layer.bottom;
    layer.top = std::min(layer.top, met.top);
    layer.bottom = std::min(std::max(layer.bottom, met.bottom), layer.top);
    if (layer.top - layer.bottom > kWorthwhileRatio * height) break;
  }
  return layer;
}

inline HeightField::Trial HeightField::Try(const DescentRay& ray, float depth) const {
  // Bilinear between cell centres; outside the grid the edge repeats.
  const Eigen::Vector2f cell = ray.CellAt(depth);
  const float u = std::min(std::max(cell.x(), 0.0f), static_cast<float>(surface_.cols) - 1.001f);
  const float v = std::min(std::max(cell.y(), 0.0f), static_cast<float>(surface_.rows) - 1.001f);
  const int left = static_cast<int>(u);
  const int first = static_cast<int>(v);
  const float tu = u - static_cast<float>(left);
  const float tv = v - static_cast<float>(first);
  const float* a = surface_[first] + left;
  const float* b = surface_[first + 1] + left;
  const float south = a[0] + tu * (a[1] - a[0]);
  const float north = b[0] + tu * (b[1] - b[0]);
  return {depth, ray.top - depth - (south + tv * (north - south))};
}

// Between a depth above the surface and one in or below it (false position).
inline float HeightField::CloseIn(const DescentRay& ray, Trial above, Trial below) const {
  const auto guess = [&] {
    const float drop = above.clearance - below.clearance;
    if (drop <= 0.0f) return below.depth;
    return above.depth + (below.depth - above.depth) * above.clearance / drop;
  };
  for (int i = 0; i < kMaxRefinements; ++i) {
    const Trial trial = Try(ray, guess());
    if (std::abs(trial.clearance) < kCloseM) return trial.depth;
    (trial.clearance > 0.0f ? above : below) = trial;
  }
  return guess();
}

float HeightField::HitDepth(const DescentRay& ray) const {
  const float step = kStepCells / std::max(ray.slide.norm(), kMinSlide);
  const Eigen::Vector2f per_cell(DescentPerCell(ray.slide.x()), DescentPerCell(ray.slide.y()));
  const int ahead_x = per_cell.x() > 0.0f, ahead_y = per_cell.y() > 0.0f;
  Trial above = Try(ray, 0.0f);
  float depth = 0.0f;
  while (depth < ray.limit) {
    const Eigen::Vector2f cell = ray.CellAt(depth);
    const int col = std::clamp(static_cast<int>(cell.x()) / kBlockSide, 0, block_top_.cols - 1);
    const int row = std::clamp(static_cast<int>(cell.y()) / kBlockSide, 0, block_top_.rows - 1);
    const float to_side =
        std::min((static_cast<float>(kBlockSide * (col + ahead_x)) - cell.x()) * per_cell.x(),
                 (static_cast<float>(kBlockSide * (row + ahead_y)) - cell.y()) * per_cell.y());
    const float leaves = depth + std::max(to_side, step);
    // Down to the block's top there is nothing to try.
    depth = std::max(depth, std::min(ray.top - block_top_(row, col), leaves));
    for (; depth < leaves && depth < ray.limit; depth += step) {
      const Trial trial = Try(ray, depth);
      if (trial.clearance <= 0.0f) return CloseIn(ray, above, trial);
      above = trial;
    }
  }
  return CloseIn(ray, above, Try(ray, std::min(depth, ray.limit)));
}

}  // namespace freelsd
