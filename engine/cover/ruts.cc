#include "engine/cover/ruts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_bands.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr int kNumDirections = 18;
// Greenness is compared with surroundings of this size.
constexpr double kSurroundingsM = 5.0;
// Distances between the two ruts of a vehicle, in steps of half a rut's width.
constexpr std::array<double, 4> kGaugesM{1.5, 1.75, 2.0, 2.25};
// This far outside the ruts the crop stands again.
constexpr double kBesideM = 0.85;
// A rut is narrower than twice this. Lines are sampled every half metre.
constexpr double kMaxRutHalfWidthM = 0.75;
constexpr double kSampleStepM = 0.5;
// Only places with greener surroundings are searched: others are soil, straw or road.
constexpr float kMinGreen = 0.05f;

// Excess green (Woebbecke et al. 1995) of the surroundings minus that of the cell. It is a share of
// the brightness, so that shade has no influence. 0 where unseen.
cv::Mat1f LackOfGreen(const Orthophoto& photo) {
  cv::Mat1f green(photo.image.size(), 0.0f), seen(photo.image.size(), 0.0f);
  for (int row = 0; row < green.rows; ++row) {
    for (int col = 0; col < green.cols; ++col) {
      if (!photo.seen(row, col)) continue;
      const cv::Vec3b& bgr = photo.image(row, col);
      const float sum = static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + 1.0f;
      green(row, col) = (3.0f * bgr[1] - sum) / sum;
      seen(row, col) = 1.0f;
    }
  }
  const int side = BoxSide(kSurroundingsM / photo.grid.cell_size_m);
  const cv::Mat1f mean = BoxMean(green, side, BoxBorder::kMirrored);
  const cv::Mat1f count = BoxMean(seen, side, BoxBorder::kMirrored);
  cv::Mat1f lack(green.size(), 0.0f);
  for (int row = 0; row < green.rows; ++row) {
    for (int col = 0; col < green.cols; ++col) {
      if (seen(row, col) == 0.0f) continue;
      const float around = mean(row, col) / count(row, col);
      if (around >= kMinGreen) lack(row, col) = around - green(row, col);
    }
  }
  return lack;
}

// Tests every direction at one cell for a pair of ruts. Uses means over lines of cells, whose
// offsets are the same for every cell.
class RutFilter {
 public:
  RutFilter(const cv::Mat1f& lack, double cell_size_m, const CoverOptions& options)
      : cell_size_(cell_size_m), min_contrast_(options.min_rut_contrast) {
    const double reach_m =
        0.5 * options.rut_filter_length_m + kGaugesM.back() + kBesideM + kMaxRutHalfWidthM;
    margin_ = static_cast<int>(std::ceil(reach_m / cell_size_m)) + 1;
    // The border counts as 0.
    cv::copyMakeBorder(
        lack, lack_, margin_, margin_, margin_, margin_, cv::BORDER_CONSTANT, cv::Scalar(0.0));
    const int num_steps = static_cast<int>(0.5 * options.rut_filter_length_m / kSampleStepM);
    for (int i = 0; i < kNumDirections; ++i) {
      directions_[i] = MakeDirection(kPi * i / kNumDirections, num_steps);
    }
    for (const auto& [right, down] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
      const double length = std::hypot(right, down) * cell_size_;
      sides_.push_back(OffsetOf(Eigen::Vector2d(right, down) * (kMaxRutHalfWidthM / length)));
    }
  }

  // The direction of highest contrast; nothing where there is no pair of ruts.
  std::optional<TrackPlace> At(int row, int col) const {
    const float* cell = lack_[row + margin_] + col + margin_;
    if (*cell < min_contrast_ || !StandsOut(cell)) return std::nullopt;
    std::optional<TrackPlace> best;
    for (int i = 0; i < kNumDirections; ++i) {
      const auto place = Along(cell, Eigen::Vector2d(col, row), i);
      if (place && (!best || place->contrast > best->contrast)) best = place;
    }
    return best;
  }

 private:
  struct Gauge {
    std::ptrdiff_t other_rut = 0;
    std::ptrdiff_t between = 0;
    std::ptrdiff_t behind = 0;
    Eigen::Vector2d step = Eigen::Vector2d::Zero();
  };
  struct Direction {
    std::vector<std::ptrdiff_t> line;
    std::ptrdiff_t before = 0;
    std::vector<Gauge> gauges;
  };

  std::ptrdiff_t OffsetOf(const Eigen::Vector2d& step) const {
    return std::lround(step.y()) * static_cast<std::ptrdiff_t>(lack_.step1()) +
           std::lround(step.x());
  }

  Direction MakeDirection(double direction, int num_steps) const {
    const Eigen::Vector2d along(std::cos(direction), std::sin(direction));
    const Eigen::Vector2d across(-along.y(), along.x());
    Direction made;
    for (int step = -num_steps; step <= num_steps; ++step) {
      made.line.push_back(OffsetOf(along * (step * kSampleStepM / cell_size_)));
    }
    const Eigen::Vector2d beside = across * (kBesideM / cell_size_);
    made.before = OffsetOf(-beside);
    for (const double gauge_m : kGaugesM) {
      const Eigen::Vector2d step = across * (gauge_m / cell_size_);
      made.gauges.push_back({OffsetOf(step), OffsetOf(0.5 * step), OffsetOf(step + beside), step});
    }
    return made;
  }

  // Whether the cell lacks green against both sides in some direction. Rejects most cells early.
  bool StandsOut(const float* cell) const {
    return std::any_of(sides_.begin(), sides_.end(), [&](std::ptrdiff_t side) {
      return *cell - std::max(cell[side], cell[-side]) >= 0.3 * min_contrast_;
    });
  }

  std::optional<TrackPlace> Along(const float* rut, const Eigen::Vector2d& place, int index) const {
    const Direction& direction = directions_[index];
    const double own = MeanLack(rut, direction);
    if (own < min_contrast_) return std::nullopt;
    const double before = MeanLack(rut + direction.before, direction);
    if (own - before < min_contrast_) return std::nullopt;
    std::optional<TrackPlace> best;
    for (const Gauge& gauge : direction.gauges) {
      const double ruts = std::min(own, MeanLack(rut + gauge.other_rut, direction));
      if (ruts < min_contrast_) continue;
      const double between = MeanLack(rut + gauge.between, direction);
      const double behind = MeanLack(rut + gauge.behind, direction);
      const double contrast = ruts - std::max({before, between, behind});
      if (contrast < min_contrast_ || (best && contrast <= best->contrast)) continue;
      best = TrackPlace{place + 0.5 * gauge.step, kPi * index / kNumDirections, contrast};
    }
    return best;
  }

  static double MeanLack(const float* middle, const Direction& direction) {
    float sum = 0.0f;
    for (const std::ptrdiff_t offset : direction.line) sum += middle[offset];
    return sum / static_cast<double>(direction.line.size());
  }

  cv::Mat1f lack_;
  int margin_ = 0;
  double cell_size_;
  double min_contrast_;
  std::array<Direction, kNumDirections> directions_;
  std::vector<std::ptrdiff_t> sides_;
};

}  // namespace

std::vector<TrackPlace> RutPairs(const Orthophoto& photo, const CoverOptions& options) {
  std::vector<TrackPlace> places;
  for (const PhotoBand& band : BandsOf(photo, kSurroundingsM + options.rut_filter_length_m)) {
    const cv::Mat1f lack = LackOfGreen(band.photo);
    const RutFilter filter(lack, photo.grid.cell_size_m, options);
    for (int row = band.first_row; row < band.end_row; ++row) {
      for (int col = 0; col < lack.cols; ++col) {
        std::optional<TrackPlace> found = filter.At(row - band.photo_first_row, col);
        if (!found) continue;
        found->place.y() += band.photo_first_row;
        places.push_back(*found);
      }
    }
  }
  return places;
}

}  // namespace freelsd
