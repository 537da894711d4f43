#include "engine/tracks/sift.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "engine/tracks/processor_targets.h"

namespace freelsd {
namespace {

// Directions around a blob: bins, deviation and reach of the weights in sigmas, and the share of
// the highest peak that makes another one.
constexpr int kNumDirectionBins = 36;
constexpr float kDirectionSigmas = 1.5F;
constexpr float kDirectionReachSigmas = 4.5F;
constexpr float kMinPeakRatio = 0.8F;
// A descriptor has this many histograms on a side, each this many sigmas wide, of this many bins.
constexpr int kNumHistograms = 4;
constexpr float kHistogramSigmas = 3.0F;
constexpr int kNumBins = 8;
constexpr float kHalfDiagonal = 1.41421356F * (kNumHistograms + 1) * 0.5F;
// Larger entries of a normalised descriptor are cut, and bytes hold this many times the rest.
constexpr float kMaxEntry = 0.2F;
constexpr float kEntryScale = 512.0F;

// Gradients of `num_cols` pixels of a row.
void Differentiate(const cv::Mat1f& layer,
                   const cv::Point& first,
                   int num_cols,
                   float* __restrict__ dx,
                   float* __restrict__ dy) {
  const float *above = layer[first.y - 1] + first.x, *row = layer[first.y] + first.x;
  const float* below = layer[first.y + 1] + first.x;
  for (int i = 0; i < num_cols; ++i) {
    dx[i] = row[i + 1] - row[i - 1];
    dy[i] = above[i] - below[i];
  }
}

// As many numbers as there may be samples; nothing is in them yet.
std::unique_ptr<float[]> Numbers(int radius) {
  const auto side = static_cast<size_t>(2 * radius + 1);
  return std::make_unique_for_overwrite<float[]>(side * side);
}

// Pixels around a blob: how the grey levels rise there, and with what weight they count.
struct Samples {
  int count = 0;
  std::unique_ptr<float[]> dx, dy, weight;
  // Of the weighted gradient; degrees in [0, 360], counter-clockwise with y up.
  std::unique_ptr<float[]> strength, direction_deg;

  explicit Samples(int radius)
      : dx(Numbers(radius)),
        dy(Numbers(radius)),
        weight(Numbers(radius)),
        strength(Numbers(radius)),
        direction_deg(Numbers(radius)) {}

  // `num_cols` pixels of a row, with their weights across.
  void Add(const cv::Mat1f& layer,
           const cv::Point& first,
           int num_cols,
           const float* weights,
           float row_weight) {
    Differentiate(layer, first, num_cols, dx.get() + count, dy.get() + count);
    std::transform(weights, weights + num_cols, weight.get() + count, [row_weight](float value) {
      return row_weight * value;
    });
    count += num_cols;
  }
};

// The arctangent is a polynomial that is off by less than 0.02 degrees.
FREELSD_SEVERAL_TARGETS void ToPolar(const float* __restrict__ dx,
                                     const float* __restrict__ dy,
                                     const float* __restrict__ weight,
                                     int count,
                                     float* __restrict__ strength,
                                     float* __restrict__ direction_deg) {
  constexpr float kTiny = 2.2204460e-16F;
  constexpr float kDegrees = 57.2957795F;
  constexpr float kP1 = 0.9997878412794807F * kDegrees, kP3 = -0.3258083974640975F * kDegrees;
  constexpr float kP5 = 0.1555786518463281F * kDegrees, kP7 = -0.04432655554792128F * kDegrees;
  for (int i = 0; i < count; ++i) {
    const float x = dx[i] < 0.0F ? -dx[i] : dx[i], y = dy[i] < 0.0F ? -dy[i] : dy[i];
    const float shorter = x < y ? x : y, longer = x < y ? y : x;
    const float ratio = shorter / (longer + kTiny), squared = ratio * ratio;
    const float acute = (((kP7 * squared + kP5) * squared + kP3) * squared + kP1) * ratio;
    const float complement = 90.0F - acute;
    const float upper_right = x < y ? complement : acute;
    const float supplement = 180.0F - upper_right;
    const float upper = dx[i] < 0.0F ? supplement : upper_right;
    const float opposite = 360.0F - upper;
    direction_deg[i] = dy[i] < 0.0F ? opposite : upper;
    strength[i] = weight[i] * std::sqrt(x * x + y * y);
  }
}

void FindGradients(Samples& samples) {
  ToPolar(samples.dx.get(),
          samples.dy.get(),
          samples.weight.get(),
          samples.count,
          samples.strength.get(),
          samples.direction_deg.get());
}

// exp(-i^2 / (2 sigma^2)) for i from -radius to radius.
std::vector<float> Falloff(float sigma_px, int radius) {
  std::vector<float> weights;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(std::exp(-static_cast<float>(i * i) / (2.0F * sigma_px * sigma_px)));
  }
  return weights;
}

const cv::Mat1f& LayerOf(const Blob& blob, const std::vector<Octave>& octaves) {
  return octaves[static_cast<size_t>(blob.octave)].layers[static_cast<size_t>(blob.layer)];
}

using DirectionHistogram = std::array<float, kNumDirectionBins>;

float At(const DirectionHistogram& histogram, int bin) {
  return histogram[static_cast<size_t>((bin + kNumDirectionBins) % kNumDirectionBins)];
}

DirectionHistogram HistogramAround(const Blob& blob, const cv::Mat1f& layer) {
  const int radius = cvRound(kDirectionReachSigmas * blob.sigma_px);
  const std::vector<float> falloff = Falloff(kDirectionSigmas * blob.sigma_px, radius);
  const float* weights = falloff.data() + radius;
  Samples samples(radius);
  const cv::Point& middle = blob.nearest;
  const int left = std::max(-radius, 1 - middle.x);
  const int right = std::min(radius, layer.cols - 2 - middle.x);
  const int bottom = std::min(radius, layer.rows - 2 - middle.y);
  for (int y = std::max(-radius, 1 - middle.y); y <= bottom; ++y) {
    samples.Add(layer, middle + cv::Point(left, y), right - left + 1, weights + left, weights[y]);
  }
  FindGradients(samples);
  DirectionHistogram histogram{};
  for (int i = 0; i < samples.count; ++i) {
    const auto at = static_cast<size_t>(i);
    const int bin = cvRound(samples.direction_deg[at] * (kNumDirectionBins / 360.0F));
    histogram[static_cast<size_t>(bin % kNumDirectionBins)] += samples.strength[at];
  }
  DirectionHistogram smooth{};
  for (int i = 0; i < kNumDirectionBins; ++i) {
    smooth[static_cast<size_t>(i)] = (At(histogram, i - 2) + At(histogram, i + 2)) / 16.0F +
                                     (At(histogram, i - 1) + At(histogram, i + 1)) / 4.0F +
                                     At(histogram, i) * 0.375F;
  }
  return smooth;
}

// Histograms with a margin of one all around, into which samples near the border spill; the bins of
// directions have two more, which belong to the first two.
constexpr int kSide = kNumHistograms + 2;
constexpr int kDepth = kNumBins + 2;
using SpatialHistograms = std::array<float, static_cast<size_t>(kSide* kSide* kDepth)>;

// Shares samples out among the eight bins around each, where they are within the margin. Rows and
// columns count histograms, bins count directions.
FREELSD_SEVERAL_TARGETS void AddSamples(const float* __restrict__ rows,
                                        const float* __restrict__ cols,
                                        const float* __restrict__ bins,
                                        const float* __restrict__ weights,
                                        int count,
                                        float* __restrict__ histograms) {
  // Shares of a few samples side by side, then one after another into the bins.
  constexpr int kNumTogether = 16;
  constexpr int kCorners[4] = {0, kDepth, kSide * kDepth, (kSide + 1) * kDepth};
  float near[4][kNumTogether], far[4][kNumTogether];
  int first_bin[kNumTogether];
  for (int first = 0; first < count; first += kNumTogether) {
    const int num_here = std::min(kNumTogether, count - first);
    for (int i = 0; i < num_here; ++i) {
      const int at = first + i;
      const bool is_inside = (rows[at] > -1.0F) & (rows[at] < kNumHistograms) & (cols[at] > -1.0F) &
                             (cols[at] < kNumHistograms);
      const float weight = is_inside ? weights[at] : 0.0F;
      // From 0 on, where to cut off is to round down.
      const float row = is_inside ? rows[at] + 1.0F : 0.0F;
      const float col = is_inside ? cols[at] + 1.0F : 0.0F;
      const float bin = bins[at] < 0.0F ? bins[at] + kNumBins : bins[at];
      const int whole_row = static_cast<int>(row), whole_col = static_cast<int>(col);
      const int whole_bin = static_cast<int>(bin);
      const float bin_share = bin - static_cast<float>(whole_bin);
      const float col_share = col - static_cast<float>(whole_col);
      const float below = weight * (row - static_cast<float>(whole_row)), above = weight - below;
      const float above_right = above * col_share, below_right = below * col_share;
      const float corners[4] = {above - above_right, above_right, below - below_right, below_right};
      for (int k = 0; k < 4; ++k) {
        far[k][i] = corners[k] * bin_share;
        near[k][i] = corners[k] - far[k][i];
      }
      first_bin[i] = (whole_row * kSide + whole_col) * kDepth + whole_bin;
    }
    for (int i = 0; i < num_here; ++i) {
      float* corner = histograms + first_bin[i];
      for (int k = 0; k < 4; ++k) {
        corner[kCorners[k]] += near[k][i];
        corner[kCorners[k] + 1] += far[k][i];
      }
    }
  }
}

Descriptor Normalised(const SpatialHistograms& histograms) {
  std::array<float, std::tuple_size_v<Descriptor>> entries{};
  float* entry = entries.data();
  for (int row = 1; row <= kNumHistograms; ++row) {
    for (int col = 1; col <= kNumHistograms; ++col) {
      const float* bins = histograms.data() + (row * kSide + col) * kDepth;
      for (int bin = 0; bin < kNumBins; ++bin) {
        *entry++ = bin < kDepth - kNumBins ? bins[bin] + bins[bin + kNumBins] : bins[bin];
      }
    }
  }
  const auto length = [&entries] {
    float squares = 0.0F;
    for (const float value : entries) squares += value * value;
    return std::sqrt(squares);
  };
  const float max_entry = kMaxEntry * length();
  for (float& value : entries) value = std::min(value, max_entry);
  const float scale = kEntryScale / std::max(length(), 1e-7F);
  Descriptor descriptor{};
  std::transform(entries.begin(), entries.end(), descriptor.begin(), [scale](float value) {
    return cv::saturate_cast<uint8_t>(value * scale);
  });
  return descriptor;
}

// From pixels around a blob to the histograms of its descriptor, the first of which is at (0, 0).
class Turn {
 public:
  Turn(float direction_deg, float width_px) {
    const float radians = direction_deg * static_cast<float>(CV_PI / 180.0);
    cosine_ = std::cos(radians) / width_px;
    sine_ = std::sin(radians) / width_px;
  }

  // Of the pixels `left` to `right` of row y.
  void PlacesOf(
      int y, int left, int right, float* __restrict__ rows, float* __restrict__ cols) const {
    const auto dy = static_cast<float>(y);
    for (int x = left; x <= right; ++x) {
      const auto dx = static_cast<float>(x);
      rows[x - left] = dx * sine_ + dy * cosine_ + kMiddle;
      cols[x - left] = dx * cosine_ - dy * sine_ + kMiddle;
    }
  }

  // Those of a row that may be inside; against rounding, one more at either end.
  std::pair<int, int> ColumnsInside(int y, std::pair<int, int> columns) const {
    const auto dy = static_cast<float>(y);
    const auto in_cols = Within(kMiddle - dy * sine_, cosine_, columns);
    return Within(kMiddle + dy * cosine_, sine_, in_cols);
  }

 private:
  static constexpr float kMiddle = 0.5F * kNumHistograms - 0.5F;

  static std::pair<int, int> Within(float start, float slope, std::pair<int, int> columns) {
    // Almost along the border: the whole row is looked at.
    if (std::abs(slope) < 1e-6F) return columns;
    const float a = (-1.0F - start) / slope, b = (kNumHistograms - start) / slope;
    const auto bounded = [](float x) { return std::clamp(x, -1e6F, 1e6F); };
    return {std::max(columns.first, cvFloor(bounded(std::min(a, b)))),
            std::min(columns.second, cvCeil(bounded(std::max(a, b))))};
  }

  float cosine_, sine_;
};

}  // namespace

std::vector<float> DirectionsOf(const Blob& blob, const std::vector<Octave>& octaves) {
  const DirectionHistogram histogram = HistogramAround(blob, LayerOf(blob, octaves));
  const float threshold = kMinPeakRatio * *std::max_element(histogram.begin(), histogram.end());
  std::vector<float> directions_deg;
  for (int i = kNumDirectionBins - 1; i >= 0; --i) {
    const float before = At(histogram, i - 1), here = At(histogram, i),
                after = At(histogram, i + 1);
    if (here <= before || here <= after || here < threshold) continue;
    const float peak =
        static_cast<float>(i) + 0.5F * (before - after) / (before - 2.0F * here + after);
    const float wrapped = peak < 0.0F ? peak + kNumDirectionBins : peak;
    directions_deg.push_back(wrapped * (360.0F / kNumDirectionBins));
  }
  std::sort(directions_deg.begin(), directions_deg.end(), std::greater<>());
  return directions_deg;
}

Descriptor Describe(const Blob& blob, float direction_deg, const std::vector<Octave>& octaves) {
  const cv::Mat1f& layer = LayerOf(blob, octaves);
  const cv::Point middle(cvRound(blob.place.x), cvRound(blob.place.y));
  const float width_px = kHistogramSigmas * blob.sigma_px;
  const int diagonal_px = static_cast<int>(std::hypot(layer.cols, layer.rows));
  const int radius = std::min(cvRound(width_px * kHalfDiagonal), diagonal_px);
  const Turn turn(direction_deg, width_px);
  const std::vector<float> falloff = Falloff(width_px * (0.5F * kNumHistograms), radius);
  const float* weights = falloff.data() + radius;
  const int bottom = std::min(radius, layer.rows - 2 - middle.y);
  Samples samples(radius);
  const auto rows = Numbers(radius), cols = Numbers(radius), bins = Numbers(radius);
  for (int y = std::max(-radius, 1 - middle.y); y <= bottom; ++y) {
    const auto [left, right] = turn.ColumnsInside(
        y, {std::max(-radius, 1 - middle.x), std::min(radius, layer.cols - 2 - middle.x)});
    if (left > right) continue;
    turn.PlacesOf(y, left, right, rows.get() + samples.count, cols.get() + samples.count);
    samples.Add(layer, middle + cv::Point(left, y), right - left + 1, weights + left, weights[y]);
  }
  FindGradients(samples);
  std::transform(
      samples.direction_deg.get(),
      samples.direction_deg.get() + samples.count,
      bins.get(),
      [direction_deg](float deg) { return (deg - direction_deg) * (kNumBins / 360.0F); });
  SpatialHistograms histograms{};
  AddSamples(
      rows.get(), cols.get(), bins.get(), samples.strength.get(), samples.count, histograms.data());
  return Normalised(histograms);
}

}  // namespace freelsd
