#include "engine/heights/block_samples.h"

#include <algorithm>
#include <stdexcept>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

using Samples = SamplePattern::Samples;

// Bilinear over the block: first + share east * `east` + share south * `south` + product * `both`.
struct Coordinate {
  float first, east, south, both;
  float last;  // the photograph's edge repeats beyond
};

struct Photograph {
  const float* pixels;
  int stride;
  Coordinate x, y;
};

inline float At(const Coordinate& of, float east, float south, float both) {
  const float value = of.first + east * of.east + south * of.south + both * of.both;
  return std::min(std::max(value, 0.0f), of.last);
}

// Adds the samples of a view, and their squares.
FREELSD_SEVERAL_TARGETS void AddView(const Photograph& view,
                                     const SamplePattern& pattern,
                                     Samples& __restrict sum,
                                     Samples& __restrict sum_of_squares) {
  const float* const pixels = view.pixels;
  const int stride = view.stride, count = pattern.count();
  const Coordinate across = view.x, down = view.y;
  for (int i = 0; i < count; ++i) {
    const auto s = static_cast<size_t>(i);
    const float x = At(across, pattern.east[s], pattern.south[s], pattern.both[s]);
    const float y = At(down, pattern.east[s], pattern.south[s], pattern.both[s]);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
    const int at = top * stride + left;
    const float upper = pixels[at] + u * (pixels[at + 1] - pixels[at]);
    const float lower = pixels[at + stride] + u * (pixels[at + stride + 1] - pixels[at + stride]);
    const float value = upper + v * (lower - upper);
    sum[s] += value;
    sum_of_squares[s] += value * value;
  }
}

Coordinate CoordinateOf(const std::array<Eigen::Vector2d, 4>& corners, int axis, int num_pixels) {
  const double nw = corners[0][axis], ne = corners[1][axis], sw = corners[2][axis],
               se = corners[3][axis];
  return {static_cast<float>(nw),
          static_cast<float>(ne - nw),
          static_cast<float>(sw - nw),
          static_cast<float>(nw - ne - sw + se),
          static_cast<float>(num_pixels) - 1.01f};
}

}  // namespace

SamplePattern::SamplePattern(int side) : side_(side) {
  if (side < 1 || side > kMaxSide)
    throw std::invalid_argument("heights: too many samples in a block");
  for (int i = 0; i < count(); ++i) {
    const auto s = static_cast<size_t>(i);
    const int row = i / side, col = i % side;
    east[s] = (static_cast<float>(col) + 0.5f) / static_cast<float>(side);
    south[s] = (static_cast<float>(row) + 0.5f) / static_cast<float>(side);
    both[s] = east[s] * south[s];
  }
}

void CompareViews(const std::vector<LiftedView>& views,
                  double lift,
                  const SamplePattern& pattern,
                  BlockOutput output) {
  Samples sum, sum_of_squares;
  std::fill_n(sum.begin(), pattern.count(), 0.0f);
  std::fill_n(sum_of_squares.begin(), pattern.count(), 0.0f);
  for (const LiftedView& view : views) {
    std::array<Eigen::Vector2d, 4> corners;
    for (size_t i = 0; i < corners.size(); ++i) corners[i] = view.corners[i].At(lift);
    AddView({view.detail->ptr<float>(),
             static_cast<int>(view.detail->step1()),
             CoordinateOf(corners, 0, view.detail->cols),
             CoordinateOf(corners, 1, view.detail->rows)},
            pattern,
            sum,
            sum_of_squares);
  }
  const float count = static_cast<float>(views.size());
  for (int i = 0; i < pattern.count(); ++i) {
    const auto s = static_cast<size_t>(i);
    const float excess = sum_of_squares[s] - sum[s] * sum[s] / count;
    const int row = i / pattern.side(), col = i % pattern.side();
    output.variance(row, col) = std::max(0.0f, excess / (count - 1.0f));
    output.power(row, col) = sum_of_squares[s] / count;
  }
}

}  // namespace freelsd
