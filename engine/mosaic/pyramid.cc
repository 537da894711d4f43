#include "engine/mosaic/pyramid.h"

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
    cv::Mat4b image;
    if (level == 0) {
      image = paint_(row, col);
    } else {
      cv::Mat4b quarters[4];
      for (const Step& step : StepsOf(turn)) {
        quarters[step.quarter] =
            Build(level - 1, 2 * row + step.quarter / 2, 2 * col + step.quarter % 2, step.turn);
      }
      image = HalvedTile(quarters, lattice_.tile_size_px);
    }
    if (image.empty()) return image;
    keep_({level, row, col, image});
    ++num_kept_;
    return image;
  }

  int num_kept() const { return num_kept_; }

 private:
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
      builder.Build(top, row, col, Turn::kEastFirst);
    }
  }
  return builder.num_kept();
}

}  // namespace freelsd
