#include "engine/heights/block_samples.h"

#include <algorithm>

#include "engine/geometry/processor_targets.h"

namespace freelsd {
namespace {

constexpr int kMaxSide = 32;

struct RowOfSamples {
  const float* pixels;
  int stride;
  float last_x, last_y;  // the edge repeats beyond
  float x, y;            // of the first sample
  float dx, dy;          // to the next
};

inline float Clamped(float value, float last) { return std::min(std::max(value, 0.0f), last); }

// Adds the samples of a row, and their squares. Bilinear.
FREELSD_SEVERAL_TARGETS void AddRow(const RowOfSamples& row,
                                    int count,
                                    float* __restrict sum,
                                    float* __restrict sum_of_squares) {
  for (int i = 0; i < count; ++i) {
    const float x = Clamped(row.x + static_cast<float>(i) * row.dx, row.last_x);
    const float y = Clamped(row.y + static_cast<float>(i) * row.dy, row.last_y);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const float u = x - static_cast<float>(left), v = y - static_cast<float>(top);
    const int at = top * row.stride + left;
    const float upper = row.pixels[at] + u * (row.pixels[at + 1] - row.pixels[at]);
    const float lower = row.pixels[at + row.stride] +
                        u * (row.pixels[at + row.stride + 1] - row.pixels[at + row.stride]);
    const float value = upper + v * (lower - upper);
    sum[i] += value;
    sum_of_squares[i] += value * value;
  }
}

}  // namespace

void CompareViews(const std::vector<LiftedView>& views, double lift, BlockOutput output) {
  const int side = output.variance.rows;
  CV_Assert(side <= kMaxSide);
  std::array<float, kMaxSide * kMaxSide> sum{}, sum_of_squares{};
  for (const LiftedView& view : views) {
    std::array<Eigen::Vector2d, 4> corners;
    for (size_t i = 0; i < corners.size(); ++i) corners[i] = view.corners[i].At(lift);
    for (int r = 0; r < side; ++r) {
      const double down = (r + 0.5) / side;
      const Eigen::Vector2d west = (1.0 - down) * corners[0] + down * corners[2];
      const Eigen::Vector2d east = (1.0 - down) * corners[1] + down * corners[3];
      const Eigen::Vector2f step = ((east - west) / side).cast<float>();
      const Eigen::Vector2f first = west.cast<float>() + 0.5f * step;
      const auto offset = static_cast<size_t>(r * side);
      AddRow({view.detail->ptr<float>(),
              static_cast<int>(view.detail->step1()),
              static_cast<float>(view.detail->cols) - 1.01f,
              static_cast<float>(view.detail->rows) - 1.01f,
              first.x(),
              first.y(),
              step.x(),
              step.y()},
             side,
             sum.data() + offset,
             sum_of_squares.data() + offset);
    }
  }
  const float count = static_cast<float>(views.size());
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < side; ++c) {
      const auto i = static_cast<size_t>(r * side + c);
      const float excess = sum_of_squares[i] - sum[i] * sum[i] / count;
      output.variance(r, c) = std::max(0.0f, excess / (count - 1.0f));
      output.power(r, c) = sum_of_squares[i] / count;
    }
  }
}

}  // namespace freelsd
