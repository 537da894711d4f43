#include "engine/mosaic/pyramid.h"

#include <opencv2/core/utility.hpp>

namespace freelsd {
namespace {

// How a Hilbert curve runs through a square: its four orientations.
enum class Turn { kSouthFirst, kEastFirst, kNorthFirst, kWestFirst };

struct Step {
  // Quarter: 0 north-west, 1 north-east, 2 south-west, 3 south-east.
  int quarter;
  Turn turn;
};

const Step (&StepsOf(Turn turn))[4] {
  using enum Turn;
  static constexpr Step kSouth[4] = {
      {0, kEastFirst}, {2, kSouthFirst}, {3, kSouthFirst}, {1, kWestFirst}};
  static constexpr Step kEast[4] = {
      {0, kSouthFirst}, {1, kEastFirst}, {3, kEastFirst}, {2, kNorthFirst}};
  static constexpr Step kNorth[4] = {
      {3, kWestFirst}, {1, kNorthFirst}, {0, kNorthFirst}, {2, kEastFirst}};
  static constexpr Step kWest[4] = {
      {3, kNorthFirst}, {2, kWestFirst}, {0, kWestFirst}, {1, kSouthFirst}};
  switch (turn) {
    case kSouthFirst:
      return kSouth;
    case kEastFirst:
      return kEast;
    case kNorthFirst:
      return kNorth;
    default:
      return kWest;
  }
}

class Builder {
 public:
  Builder(const MosaicLattice& lattice,
          const std::function<cv::Mat4b(int row, int col)>& paint,
          const std::function<void(const MosaicTile&)>& keep)
      : lattice_(lattice), paint_(paint), keep_(keep) {}

  // The tile after all tiles that it consists of.
  cv::Mat4b Build(int level, int row, int col, Turn turn) {
    if (!lattice_.TilesOf(level).contains({col, row})) return {};
    cv::Mat4b quarters[4];
    if (level == 1) PaintQuarters(row, col, quarters);
    for (const Step& step : StepsOf(turn)) {
      const int below = 2 * row + step.quarter / 2, beside = 2 * col + step.quarter % 2;
      cv::Mat4b& quarter = quarters[step.quarter];
      if (level == 1) {
        Keep({0, below, beside, quarter});
      } else {
        quarter = Build(level - 1, below, beside, step.turn);
      }
    }
    cv::Mat4b image = HalvedTile(quarters, lattice_.tile_size_px);
    Keep({level, row, col, image});
    return image;
  }

  // A tile of the finest level that is the last one too.
  void BuildAlone(int row, int col) { Keep({0, row, col, paint_(row, col)}); }

  int num_kept() const { return num_kept_; }

 private:
  void PaintQuarters(int row, int col, cv::Mat4b (&quarters)[4]) {
    cv::parallel_for_({0, 4}, [&](const cv::Range& range) {
      for (int i = range.start; i < range.end; ++i) {
        const int below = 2 * row + i / 2, beside = 2 * col + i % 2;
        if (lattice_.tiles.contains({beside, below})) quarters[i] = paint_(below, beside);
      }
    });
  }

  void Keep(const MosaicTile& tile) {
    if (tile.image.empty()) return;
    keep_(tile);
    ++num_kept_;
  }

  const MosaicLattice& lattice_;
  const std::function<cv::Mat4b(int row, int col)>& paint_;
  const std::function<void(const MosaicTile&)>& keep_;
  int num_kept_ = 0;
};

cv::Vec4b MeanOf(const cv::Vec4b& a, const cv::Vec4b& b, const cv::Vec4b& c, const cv::Vec4b& d) {
  const int alpha = a[3] + b[3] + c[3] + d[3];
  if (alpha == 0) return cv::Vec4b::all(0);
  cv::Vec4b mean;
  for (int i = 0; i < 3; ++i) {
    const int sum = a[i] * a[3] + b[i] * b[3] + c[i] * c[3] + d[i] * d[3];
    mean[i] = static_cast<uint8_t>((sum + alpha / 2) / alpha);
  }
  mean[3] = static_cast<uint8_t>((alpha + 2) / 4);
  return mean;
}

}  // namespace

cv::Mat4b HalvedTile(const cv::Mat4b (&quarters)[4], int tile_size_px) {
  const int half = tile_size_px / 2;
  cv::Mat4b halved;
  for (int i = 0; i < 4; ++i) {
    const cv::Mat4b& quarter = quarters[i];
    if (quarter.empty()) continue;
    if (halved.empty()) halved = cv::Mat4b(tile_size_px, tile_size_px, cv::Vec4b::all(0));
    cv::Mat4b out = halved(cv::Rect(i % 2 * half, i / 2 * half, half, half));
    for (int row = 0; row < half; ++row) {
      const cv::Vec4b* upper = quarter[2 * row];
      const cv::Vec4b* lower = quarter[2 * row + 1];
      for (int col = 0; col < half; ++col) {
        out(row, col) =
            MeanOf(upper[2 * col], upper[2 * col + 1], lower[2 * col], lower[2 * col + 1]);
      }
    }
  }
  return halved;
}

int BuildPyramid(const MosaicLattice& lattice,
                 const std::function<cv::Mat4b(int row, int col)>& paint,
                 const std::function<void(const MosaicTile&)>& keep) {
  Builder builder(lattice, paint, keep);
  const int top = lattice.num_levels - 1;
  const cv::Rect tiles = lattice.TilesOf(top);
  for (int row = tiles.y; row < tiles.br().y; ++row) {
    for (int col = tiles.x; col < tiles.br().x; ++col) {
      if (top == 0) {
        builder.BuildAlone(row, col);
      } else {
        builder.Build(top, row, col, Turn::kEastFirst);
      }
    }
  }
  return builder.num_kept();
}

}  // namespace freelsd
