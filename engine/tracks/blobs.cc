#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <tuple>

#include "engine/tracks/processor_targets.h"
#include "engine/tracks/sift.h"

namespace freelsd {
namespace {

constexpr int kNumDifferences = kNumScalesPerOctave + 2;
// Pixels along the border where nothing is sought.
constexpr int kBorderPx = 5;
constexpr int kMaxNumSteps = 5;
// Largest ratio of the two principal curvatures: beyond it, it is an edge.
constexpr float kMaxEdgeRatio = 10.0F;
constexpr float kFullRangeGrey = 255.0F;

// Of one row: what each layer is brighter than the one before.
FREELSD_SEVERAL_TARGETS void Subtract(const float* __restrict__ layer,
                                      const float* __restrict__ next,
                                      int num_cols,
                                      float* __restrict__ difference) {
  for (int x = 0; x < num_cols; ++x) difference[x] = next[x] - layer[x];
}

// The largest and the least of nine rows, pixel by pixel: three of one difference, of the one
// before and of the one after.
using NineRows = std::array<const float*, 9>;
FREELSD_SEVERAL_TARGETS void RangeOfNine(const NineRows& rows,
                                         int num_cols,
                                         float* __restrict__ high,
                                         float* __restrict__ low) {
  const auto [a, b, c, d, e, f, g, h, i] = rows;
  for (int x = 0; x < num_cols; ++x) {
    float most = a[x], least = a[x];
    for (const float value : {b[x], c[x], d[x], e[x], f[x], g[x], h[x], i[x]}) {
      most = most < value ? value : most;
      least = value < least ? value : least;
    }
    high[x] = most;
    low[x] = least;
  }
}

// 1 where a value is positive and the largest of the range of its own and its neighbours' columns,
// or negative and the least. Nothing is written for the first and the last column.
FREELSD_SEVERAL_TARGETS void MarkExtrema(const float* __restrict__ value,
                                         const float* __restrict__ high,
                                         const float* __restrict__ low,
                                         int num_cols,
                                         uint8_t* __restrict__ marks) {
  for (int x = 1; x < num_cols - 1; ++x) {
    const int is_peak = static_cast<int>(value[x] > 0.0F) & static_cast<int>(value[x] == high[x]) &
                        static_cast<int>(value[x] >= high[x - 1]) &
                        static_cast<int>(value[x] >= high[x + 1]);
    const int is_pit = static_cast<int>(value[x] < 0.0F) & static_cast<int>(value[x] == low[x]) &
                       static_cast<int>(value[x] <= low[x - 1]) &
                       static_cast<int>(value[x] <= low[x + 1]);
    marks[x] = static_cast<uint8_t>(is_peak | is_pit);
  }
}

// Three rows of every difference, and what extrema they have in the middle row.
class ExtremaSearch {
 public:
  explicit ExtremaSearch(const Octave& octave)
      : octave_(octave),
        num_cols_(octave.layers[0].cols),
        high_(static_cast<size_t>(num_cols_), 0.0F),
        low_(high_),
        marks_(static_cast<size_t>(num_cols_), 0) {
    for (auto& rows : rows_) rows.fill(high_);
  }

  void Load(int y) {
    for (size_t i = 0; i < rows_.size(); ++i) {
      Subtract(octave_.layers[i][y],
               octave_.layers[i + 1][y],
               num_cols_,
               rows_[i][static_cast<size_t>(y % 3)].data());
    }
  }

  // Of row y, when it and its two neighbours are loaded: calls found(layer, x).
  template <typename Found>
  void ForEach(int y, const Found& found) {
    for (size_t i = 1; i + 1 < rows_.size(); ++i) {
      NineRows rows{};
      for (size_t k = 0; k < rows.size(); ++k) rows[k] = rows_[i - 1 + k / 3][k % 3].data();
      RangeOfNine(rows, num_cols_, high_.data(), low_.data());
      MarkExtrema(rows_[i][static_cast<size_t>(y % 3)].data(),
                  high_.data(),
                  low_.data(),
                  num_cols_,
                  marks_.data());
      const uint8_t *first = marks_.data(), *end = first + num_cols_ - kBorderPx;
      const uint8_t* mark = first + kBorderPx;
      while ((mark = static_cast<const uint8_t*>(std::memchr(mark, 1, end - mark))) != nullptr) {
        found(static_cast<int>(i), static_cast<int>(mark - first));
        ++mark;
      }
    }
  }

 private:
  const Octave& octave_;
  int num_cols_;
  std::array<std::array<std::vector<float>, 3>, kNumDifferences> rows_;
  std::vector<float> high_, low_;
  std::vector<uint8_t> marks_;
};

// Derivatives of the differences at a pixel, in shares of the full range; x, y, layer.
struct Derivatives {
  cv::Vec3f first;
  cv::Matx33f second;
};

float DifferenceAt(const Octave& octave, int layer, const cv::Point& at) {
  const auto i = static_cast<size_t>(layer);
  return octave.layers[i + 1](at) - octave.layers[i](at);
}

Derivatives DerivativesAt(const Octave& octave, int layer, const cv::Point& at) {
  std::array<const float*, 4> pixel{};
  for (size_t i = 0; i < pixel.size(); ++i) {
    pixel[i] = &octave.layers[static_cast<size_t>(layer) - 1 + i](at);
  }
  const auto row_step = static_cast<ptrdiff_t>(octave.layers[0].step1());
  const auto value = [&](int dx, int dy, int dlayer) {
    const auto i = static_cast<size_t>(1 + dlayer);
    const ptrdiff_t offset = dy * row_step + dx;
    return pixel[i + 1][offset] - pixel[i][offset];
  };
  constexpr float kScale = 1.0F / kFullRangeGrey;
  const auto mixed = [&](float a, float b, float c, float d) {
    return (a - b - c + d) * (0.25F * kScale);
  };
  const float twice = value(0, 0, 0) * 2.0F;
  const float xx = (value(1, 0, 0) + value(-1, 0, 0) - twice) * kScale;
  const float yy = (value(0, 1, 0) + value(0, -1, 0) - twice) * kScale;
  const float ss = (value(0, 0, 1) + value(0, 0, -1) - twice) * kScale;
  const float xy = mixed(value(1, 1, 0), value(-1, 1, 0), value(1, -1, 0), value(-1, -1, 0));
  const float xs = mixed(value(1, 0, 1), value(-1, 0, 1), value(1, 0, -1), value(-1, 0, -1));
  const float ys = mixed(value(0, 1, 1), value(0, -1, 1), value(0, 1, -1), value(0, -1, -1));
  return {{(value(1, 0, 0) - value(-1, 0, 0)) * (0.5F * kScale),
           (value(0, 1, 0) - value(0, -1, 0)) * (0.5F * kScale),
           (value(0, 0, 1) - value(0, 0, -1)) * (0.5F * kScale)},
          {xx, xy, xs, xy, yy, ys, xs, ys, ss}};
}

bool IsInside(const Octave& octave, int layer, const cv::Point& at) {
  const cv::Mat1f& first = octave.layers[0];
  return layer >= 1 && layer <= kNumScalesPerOctave && at.x >= kBorderPx && at.y >= kBorderPx &&
         at.x < first.cols - kBorderPx && at.y < first.rows - kBorderPx;
}

bool IsEdge(const cv::Matx33f& second) {
  const float trace = second(0, 0) + second(1, 1);
  const float determinant = second(0, 0) * second(1, 1) - second(0, 1) * second(0, 1);
  return determinant <= 0.0F ||
         trace * trace * kMaxEdgeRatio >= (kMaxEdgeRatio + 1) * (kMaxEdgeRatio + 1) * determinant;
}

// The peak of the parabola through an extremum and its neighbours; moves on where that is nearer to
// another pixel.
std::optional<Blob> Refine(const Octave& octave, int layer, cv::Point at, float min_contrast) {
  for (int step = 0; step < kMaxNumSteps; ++step) {
    const Derivatives derivatives = DerivativesAt(octave, layer, at);
    const cv::Vec3f offset = -derivatives.second.solve(derivatives.first, cv::DECOMP_LU);
    const auto is_nearest = [](float part) { return std::abs(part) < 0.5F; };
    if (std::all_of(offset.val, offset.val + 3, is_nearest)) {
      const float value = DifferenceAt(octave, layer, at) / kFullRangeGrey;
      Blob blob;
      blob.contrast = std::abs(value + 0.5F * derivatives.first.dot(offset));
      if (blob.contrast < min_contrast || IsEdge(derivatives.second)) return std::nullopt;
      blob.layer = layer;
      blob.nearest = at;
      blob.place = {static_cast<float>(at.x) + offset[0], static_cast<float>(at.y) + offset[1]};
      blob.sigma_px = kFirstSigmaPx *
                      std::pow(2.0F, (static_cast<float>(layer) + offset[2]) / kNumScalesPerOctave);
      return blob;
    }
    const auto is_near = [](float part) { return std::abs(part) < 1e6F; };
    if (!std::all_of(offset.val, offset.val + 3, is_near)) return std::nullopt;
    at += cv::Point(cvRound(offset[0]), cvRound(offset[1]));
    layer += cvRound(offset[2]);
    if (!IsInside(octave, layer, at)) return std::nullopt;
  }
  return std::nullopt;
}

// The strongest first, then by place and size.
auto Order(const Blob& blob) {
  const cv::Point2f place = blob.PlaceInImage();
  return std::tuple(-blob.contrast, place.x, place.y, -blob.octave, -blob.sigma_px);
}

void AppendBlobs(const Octave& octave, int index, float min_contrast, std::vector<Blob>& blobs) {
  const int num_rows = octave.layers[0].rows;
  if (std::min(octave.layers[0].cols, num_rows) < kMinOctaveSidePx) return;
  ExtremaSearch search(octave);
  search.Load(kBorderPx - 1);
  search.Load(kBorderPx);
  for (int y = kBorderPx; y < num_rows - kBorderPx; ++y) {
    search.Load(y + 1);
    search.ForEach(y, [&](int layer, int x) {
      std::optional<Blob> blob = Refine(octave, layer, {x, y}, min_contrast);
      if (!blob) return;
      blob->octave = index;
      blobs.push_back(*blob);
    });
  }
}

}  // namespace

cv::Point2f Blob::PlaceInImage() const { return place * std::ldexp(1.0F, octave - 1); }

std::vector<Blob> FindBlobs(const std::vector<Octave>& octaves, float min_contrast) {
  std::vector<Blob> blobs;
  for (size_t i = 0; i < octaves.size(); ++i) {
    AppendBlobs(octaves[i], static_cast<int>(i), min_contrast, blobs);
  }
  std::sort(
      blobs.begin(), blobs.end(), [](const Blob& a, const Blob& b) { return Order(a) < Order(b); });
  // Neighbouring extrema may move to the same peak.
  const auto is_same = [](const Blob& a, const Blob& b) { return Order(a) == Order(b); };
  blobs.erase(std::unique(blobs.begin(), blobs.end(), is_same), blobs.end());
  return blobs;
}

}  // namespace freelsd
