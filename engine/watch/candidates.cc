#include "engine/watch/candidates.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// From one level to the next.
constexpr double kLevelRatio = 1.4;
constexpr double kHighestLevel = 60.0;
// The ground around a candidate: a ring this far from it and this wide.
constexpr double kRingGapM = 0.3;
constexpr double kRingWidthM = 0.9;
// The part of the ring with the most similar change: a shadow that goes on crosses the ring there.
constexpr double kRingShare = 0.85;

float Quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0.0f;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// The pixels of a candidate and those around it, within a window of the canvas.
struct Neighbourhood {
  cv::Rect window;
  cv::Mat1b is_inside, is_ring;
};

std::vector<float> ValuesIn(const cv::Mat1f& values, const cv::Mat1b& mask) {
  std::vector<float> found;
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      if (mask(row, col) != 0) found.push_back(values(row, col));
    }
  }
  return found;
}

double MeanIn(const cv::Mat1f& values, const cv::Mat1b& mask) { return cv::mean(values, mask)[0]; }

class CandidateFinder {
 public:
  CandidateFinder(const StripChange& change, const StripCanvas& canvas, const WatchOptions& options)
      : change_(change), options_(options), pixel_m_(canvas.grid.cell_size_m) {
    cv::erode(change.is_shown, is_well_inside_, cv::Mat());
    gap_px_ = std::max(1, static_cast<int>(std::lround(kRingGapM / pixel_m_)));
    ring_px_ = gap_px_ + std::max(2, static_cast<int>(std::lround(kRingWidthM / pixel_m_)));
    // What lies farther from the strip than a thing is long belongs to nothing on it.
    const int reach_px = static_cast<int>(options.max_size_m / pixel_m_) + ring_px_ + 1;
    const cv::Rect strip = cv::boundingRect(change.is_compared);
    part_ = cv::Rect(strip.x - reach_px,
                     strip.y - reach_px,
                     strip.width + 2 * reach_px,
                     strip.height + 2 * reach_px) &
            cv::Rect({}, change.is_shown.size());
  }

  void AddOf(Band band, float sign, std::vector<ChangeCandidate>& result) const {
    if (part_.empty()) return;
    const cv::Mat1f deviations = sign * change_.Of(band).deviations(part_);
    double highest = 0.0;
    cv::minMaxLoc(deviations, nullptr, &highest, nullptr, nullptr, change_.is_compared(part_));
    for (double level = options_.grow_deviations; level <= std::min(highest, kHighestLevel);
         level *= kLevelRatio) {
      AddAt(band, sign, cv::Mat1b(deviations >= level), result);
    }
  }

 private:
  void AddAt(Band band,
             float sign,
             const cv::Mat1b& is_changed,
             std::vector<ChangeCandidate>& result) const {
    cv::Mat1i labels, stats;
    cv::Mat1d centers;
    const int count = cv::connectedComponentsWithStats(is_changed, labels, stats, centers, 8);
    const double least_px = options_.min_area_m2 / (pixel_m_ * pixel_m_);
    const double most_px = options_.max_size_m / pixel_m_;
    for (int i = 1; i < count; ++i) {
      const cv::Rect box(stats(i, cv::CC_STAT_LEFT),
                         stats(i, cv::CC_STAT_TOP),
                         stats(i, cv::CC_STAT_WIDTH),
                         stats(i, cv::CC_STAT_HEIGHT));
      if (stats(i, cv::CC_STAT_AREA) < least_px || std::max(box.width, box.height) > most_px) {
        continue;
      }
      cv::Mat1b is_inside = labels(box) == i;
      if (cv::countNonZero(is_inside & change_.is_compared(box + part_.tl())) == 0) continue;
      result.push_back(Measured(band, sign, is_inside, box + part_.tl()));
    }
  }

  Neighbourhood Around(const cv::Mat1b& is_inside, const cv::Rect& box) const {
    Neighbourhood around;
    const cv::Rect wide(
        box.x - ring_px_, box.y - ring_px_, box.width + 2 * ring_px_, box.height + 2 * ring_px_);
    around.window = wide & cv::Rect({}, change_.is_shown.size());
    around.is_inside = cv::Mat1b::zeros(around.window.size());
    is_inside.copyTo(around.is_inside(box - around.window.tl()));
    const auto grown = [&](int radius_px) {
      cv::Mat1b result;
      const cv::Size size(2 * radius_px + 1, 2 * radius_px + 1);
      cv::dilate(around.is_inside, result, cv::getStructuringElement(cv::MORPH_ELLIPSE, size));
      return result;
    };
    around.is_ring = grown(ring_px_) & ~grown(gap_px_) & change_.is_shown(around.window);
    return around;
  }

  ChangeCandidate Measured(Band band,
                           float sign,
                           const cv::Mat1b& is_inside,
                           const cv::Rect& box) const {
    ChangeCandidate candidate;
    candidate.band = band;
    const Neighbourhood around = Around(is_inside, box);
    std::vector<cv::Point> pixels;
    cv::findNonZero(is_inside, pixels);
    candidate.box = cv::minAreaRect(pixels);
    candidate.box.center += cv::Point2f(box.tl());
    candidate.num_pixels = static_cast<int>(pixels.size());
    const cv::Size2f& size = candidate.box.size;
    candidate.length_m = pixel_m_ * (std::max(size.width, size.height) + 1.0);
    candidate.width_m = pixel_m_ * (std::min(size.width, size.height) + 1.0);
    candidate.area_m2 = pixel_m_ * pixel_m_ * candidate.num_pixels;
    const cv::Mat1b on_strip = is_inside & change_.is_compared(box);
    candidate.on_strip_ratio = double(cv::countNonZero(on_strip)) / candidate.num_pixels;
    candidate.is_cut = cv::countNonZero(is_inside & ~is_well_inside_(box)) > 0;
    const BandChange& own = change_.Of(band);
    const cv::Mat1f deviations = sign * own.deviations(box);
    cv::minMaxLoc(deviations, nullptr, &candidate.deviations, nullptr, nullptr, on_strip);
    candidate.mean_deviations = MeanIn(deviations, is_inside);
    const double mean = sign * MeanIn(own.change(box), is_inside);
    const cv::Mat1f ring = sign * own.change(around.window);
    const std::vector<float> changes_around = ValuesIn(ring, around.is_ring);
    const double similar = Quantile(changes_around, kRingShare);
    const double excess = mean - Quantile(changes_around, 0.5);
    candidate.isolation = excess > 0.0 ? std::clamp((mean - similar) / excess, -1.0, 1.0) : -1.0;
    for (size_t i = 0; i < change_.bands.size(); ++i) {
      const BandChange& each = change_.bands[i];
      const auto against_ring = [&](const cv::Mat1f& values) {
        return MeanIn(values(box), is_inside) -
               Quantile(ValuesIn(values(around.window), around.is_ring), 0.5);
      };
      candidate.contrast[i] = against_ring(each.change);
      candidate.own_contrast[i] = against_ring(each.seen);
    }
    return candidate;
  }

  const StripChange& change_;
  const WatchOptions& options_;
  const double pixel_m_;
  cv::Mat1b is_well_inside_;
  int gap_px_ = 1, ring_px_ = 1;
  cv::Rect part_;
};

}  // namespace

std::vector<ChangeCandidate> CandidatesIn(const StripChange& change,
                                          const StripCanvas& canvas,
                                          const WatchOptions& options) {
  const CandidateFinder finder(change, canvas, options);
  std::vector<ChangeCandidate> candidates;
  for (const Band band : {Band::kBrightness, Band::kGreenExcess, Band::kRedBlue}) {
    for (const float sign : {1.0f, -1.0f}) finder.AddOf(band, sign, candidates);
  }
  return candidates;
}

bool StandsAlone(const ChangeCandidate& candidate, const WatchOptions& options) {
  const auto band = static_cast<size_t>(candidate.band);
  const double change = candidate.contrast[band];
  return candidate.isolation >= options.min_isolation_ratio &&
         candidate.own_contrast[band] * (change > 0.0 ? 1.0 : -1.0) >=
             options.min_own_contrast_ratio * std::abs(change);
}

std::array<double, kNumCues> CuesOf(const ChangeCandidate& candidate) {
  const auto [brightness, green, red_blue] = candidate.contrast;
  const auto own = static_cast<size_t>(candidate.band);
  const double change = candidate.contrast[own];
  const double stands_out =
      change == 0.0 ? 0.0 : std::clamp(candidate.own_contrast[own] / change, -1.0, 1.5);
  const double area = std::log(candidate.area_m2);
  // The shade is bluer than the sun.
  constexpr double kBlueOfShade = 0.2;
  const double tint = red_blue - kBlueOfShade * brightness;
  return {1.0,
          std::log(candidate.mean_deviations),
          candidate.isolation,
          stands_out,
          std::min(std::abs(brightness), 1.5),
          std::min(std::abs(green), 0.5),
          std::min(std::abs(tint), 0.8),
          area,
          area * area,
          std::log(candidate.length_m / candidate.width_m),
          std::min(candidate.width_m, 8.0),
          candidate.on_strip_ratio,
          candidate.is_cut ? 1.0 : 0.0};
}

double EvidenceOf(const ChangeCandidate& candidate) {
  // Logistic regression of "freelsd-watch fit" on tuning worlds 2003 to 2005, 571 photographs.
  constexpr std::array<double, kNumCues> kWeights{-10.417,
                                                  2.056,
                                                  4.074,
                                                  2.670,
                                                  6.434,
                                                  11.791,
                                                  -1.204,
                                                  0.689,
                                                  -0.269,
                                                  0.139,
                                                  -0.227,
                                                  1.870,
                                                  -6.014};
  const std::array<double, kNumCues> cues = CuesOf(candidate);
  double sum = 0.0;
  for (size_t i = 0; i < kNumCues; ++i) sum += kWeights[i] * cues[i];
  return sum;
}

}  // namespace freelsd
