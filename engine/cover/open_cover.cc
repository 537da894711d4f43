#include "engine/cover/open_cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Deviation of the blur before the comparison: photographs align to half a pixel.
constexpr double kOpenBlurM = 0.25;
// Side of the compared squares. Within a square, one photograph may be brighter as a whole because
// of exposure, or because a slope reflects differently to either side.
constexpr double kWindowM = 2.0;
constexpr double kExposureM = 8.0;
// Share of a map cell that both photographs must show.
constexpr float kMinShownShare = 0.5f;
// Keeps the logarithm of black finite.
constexpr float kLeastBrightness = 10.0f;
// Avoids a division by zero: the mean is 0 where nothing counts.
constexpr double kMinCellWeight = 1e-6;

// Logarithms of all sums of three bytes.
std::array<float, 3 * 255 + 1> LogarithmsOfSums() {
  std::array<float, 3 * 255 + 1> logarithms;
  for (size_t sum = 0; sum < logarithms.size(); ++sum) {
    logarithms[sum] = std::log(kLeastBrightness + static_cast<float>(sum));
  }
  return logarithms;
}

// Of a part of the image, blurred.
cv::Mat1f LogBrightness(const cv::Mat3b& image, const cv::Rect& part, double blur_px) {
  static const auto kLogarithms = LogarithmsOfSums();
  // The blur reaches as far as OpenCV's kernel for floats.
  const int halo = static_cast<int>(std::lround(8.0 * blur_px + 1.0)) / 2 + 1;
  const cv::Rect whole({}, image.size());
  const cv::Rect wide =
      whole & cv::Rect(part.tl() - cv::Point(halo, halo), part.br() + cv::Point(halo, halo));
  const cv::Mat3b colors = image(wide);
  cv::Mat1f brightness(wide.size());
  std::transform(colors.begin(), colors.end(), brightness.begin(), [](const cv::Vec3b& color) {
    return kLogarithms[static_cast<size_t>(color[0] + color[1] + color[2])];
  });
  cv::GaussianBlur(brightness, brightness, {}, blur_px);
  return brightness(part - wide.tl());
}

// Means over squares. Only pixels with counts = 1 are included.
class WindowMean {
 public:
  WindowMean(const cv::Mat1f& counts, double side_cells)
      : side_(BoxSide(side_cells)), weight_(Box(counts) + kMinCellWeight) {}
  cv::Mat1f Of(const cv::Mat1f& counted) const { return Box(counted) / weight_; }

 private:
  cv::Mat1f Box(const cv::Mat1f& values) const {
    return BoxMean(values, side_, BoxBorder::kMirrored);
  }

  int side_;
  cv::Mat1f weight_;
};

// The map cells that one pair of views shows, and their bounding rectangle.
struct PairCells {
  std::vector<cv::Point> cells;
  cv::Rect around;
};

std::map<std::pair<int, int>, PairCells> CellsOfPairs(const Orthophoto& photo) {
  std::map<std::pair<int, int>, PairCells> pairs;
  for (int row = 0; row < photo.view.rows; ++row) {
    for (int col = 0; col < photo.view.cols; ++col) {
      const int first = photo.view(row, col), second = photo.second_view(row, col);
      if (first < 0 || second < 0) continue;
      PairCells& pair = pairs[{first, second}];
      pair.cells.emplace_back(col, row);
      const cv::Rect cell(col, row, 1, 1);
      pair.around = pair.around.empty() ? cell : pair.around | cell;
    }
  }
  return pairs;
}

cv::Mat DiscOf(double radius_m, double cell_size_m) {
  const int half = static_cast<int>(std::lround(radius_m / cell_size_m));
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * half + 1, 2 * half + 1});
}

// Small connected things with meadow around them.
cv::Mat1b LoneThings(const cv::Mat1b& things,
                     const cv::Mat1b& is_meadow,
                     const PhotoOptions& options,
                     double cell_size_m) {
  cv::Mat1b lone = cv::Mat1b::zeros(things.size());
  cv::Mat1i labels, stats;
  cv::Mat centroids;
  const int num_labels = cv::connectedComponentsWithStats(things, labels, stats, centroids);
  const int halo = static_cast<int>(std::ceil(options.lone_surroundings_m / cell_size_m)) + 1;
  const cv::Mat edge = DiscOf(options.open_cover_margin_m, cell_size_m);
  const cv::Mat surroundings = DiscOf(options.lone_surroundings_m, cell_size_m);
  for (int label = 1; label < num_labels; ++label) {
    const cv::Size size(stats(label, cv::CC_STAT_WIDTH), stats(label, cv::CC_STAT_HEIGHT));
    if (std::max(size.width, size.height) * cell_size_m > options.max_lone_size_m) continue;
    const cv::Rect around = cv::Rect(stats(label, cv::CC_STAT_LEFT) - halo,
                                     stats(label, cv::CC_STAT_TOP) - halo,
                                     size.width + 2 * halo,
                                     size.height + 2 * halo) &
                            cv::Rect(cv::Point(), things.size());
    const cv::Mat1b thing = labels(around) == label;
    cv::Mat1b with_edge, with_surroundings;
    cv::dilate(thing, with_edge, edge);
    cv::dilate(thing, with_surroundings, surroundings);
    const cv::Mat1b ring = with_surroundings & ~with_edge;
    const int num_meadow = cv::countNonZero(ring & is_meadow(around));
    if (num_meadow < options.min_lone_meadow_ratio * cv::countNonZero(ring)) continue;
    lone(around).setTo(uint8_t{255}, with_edge);
  }
  return lone;
}

// Narrow open cover that is too wide to be chance.
cv::Mat1b NarrowCover(const cv::Mat1b& narrow, const PhotoOptions& options, double cell_size_m) {
  const int narrowest =
      std::max(1, static_cast<int>(std::lround(options.min_narrow_cover_m / cell_size_m)));
  // OpenCV's opening with an even square shifts the result. The second anchor shifts it back.
  const cv::Mat square = cv::Mat1b::ones(narrowest, narrowest);
  cv::Mat1b opened;
  cv::erode(narrow, opened, square, {0, 0});
  cv::dilate(opened, opened, square, {narrowest - 1, narrowest - 1});
  return opened;
}

// Metres to add over narrow cover and lone things.
cv::Mat1f Allowances(const cv::Mat1b& narrow,
                     const MeadowCells& cells,
                     const PhotoOptions& options,
                     double cell_size_m) {
  const cv::Mat1b things = cells.objects.empty() ? narrow : cv::Mat1b(narrow | cells.objects);
  cv::Mat1b is_lone = LoneThings(things, cells.is_meadow, options, cell_size_m);
  cv::Mat1b is_narrow;
  cv::dilate(narrow, is_narrow, DiscOf(options.open_cover_margin_m, cell_size_m));
  if (options.lone_allowance_m > options.narrow_cover_allowance_m) {
    is_narrow &= ~is_lone;
  } else {
    is_lone &= ~is_narrow;
  }
  cv::Mat1f allowance_m = cv::Mat1f::zeros(narrow.size());
  allowance_m.setTo(options.narrow_cover_allowance_m, is_narrow);
  allowance_m.setTo(options.lone_allowance_m, is_lone);
  return allowance_m;
}

}  // namespace

cv::Mat1f PhotoDisagreement(const Orthophoto& photo, const Grid& grid) {
  if (photo.second_image.empty()) return {};
  cv::Mat1f by_cell(photo.view.size(), std::numeric_limits<float>::quiet_NaN());
  const double cell = photo.grid.cell_size_m;
  const int parts = static_cast<int>(std::lround(grid.cell_size_m / cell));
  // Exposure differs between views, so each pair of views is compared separately.
  for (const auto& [views, pair] : CellsOfPairs(photo)) {
    const cv::Rect box(parts * pair.around.tl(),
                       cv::Size(parts * pair.around.width, parts * pair.around.height));
    const cv::Mat1f ratio = LogBrightness(photo.image, box, kOpenBlurM / cell) -
                            LogBrightness(photo.second_image, box, kOpenBlurM / cell);
    cv::Mat1b is_shown = cv::Mat1b::zeros(box.size());
    for (const cv::Point& place : pair.cells) {
      is_shown(cv::Rect(parts * (place - pair.around.tl()), cv::Size(parts, parts))) = 255;
    }
    is_shown &= photo.seen(box) & photo.second_seen(box);
    cv::Mat1f shown, counts;
    is_shown.convertTo(shown, CV_32F, 1.0 / 255.0);
    // The blur mixes in other pairs of views, so a border of one cell is left out.
    cv::Mat1b inner;
    cv::erode(is_shown, inner, {}, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar::all(0.0));
    inner.convertTo(counts, CV_32F, 1.0 / 255.0);
    const cv::Mat1f exposure = WindowMean(counts, kExposureM / cell).Of(ratio.mul(counts));
    const cv::Mat1f rest = (ratio - exposure).mul(counts);
    cv::Mat1f deviation, shares;
    cv::sqrt(WindowMean(counts, kWindowM / cell).Of(rest.mul(rest)), deviation);
    cv::resize(shown, shares, pair.around.size(), 0.0, 0.0, cv::INTER_AREA);
    cv::resize(deviation, deviation, pair.around.size(), 0.0, 0.0, cv::INTER_AREA);
    for (const cv::Point& place : pair.cells) {
      const cv::Point in_box = place - pair.around.tl();
      if (shares(in_box) >= kMinShownShare) by_cell(place) = deviation(in_box);
    }
  }
  return by_cell;
}

OpenCover FindOpenCover(const cv::Mat1f& disagreement,
                        const Grid& grid,
                        const MeadowCells& cells,
                        const PhotoOptions& options) {
  OpenCover cover;
  if (disagreement.empty()) return cover;
  const double cell = grid.cell_size_m;
  cv::Mat1b is_open = disagreement > options.max_photo_disagreement;
  // NaN differs from itself; OpenCV's != does not find every NaN.
  const cv::Mat1b is_unshown = ~cv::Mat1b(disagreement == disagreement);
  is_open.setTo(uint8_t{0}, cells.is_clear_class);
  // Crowns at the edge of an unmeasured wood are part of the same body.
  cv::Mat1b bodies;
  cv::morphologyEx(
      is_open | is_unshown, bodies, cv::MORPH_OPEN, DiscOf(options.min_open_cover_radius_m, cell));
  cover.allowance_m =
      Allowances(NarrowCover(is_open & ~bodies, options, cell), cells, options, cell);
  is_open &= bodies;
  cv::dilate(is_open, is_open, DiscOf(options.open_cover_margin_m, cell));
  cover.is_unknown = is_open | is_unshown;
  cover.is_compared = true;
  return cover;
}

ElevationMap WithCover(const ElevationMap& map, const OpenCover& cover) {
  if (!cover.is_compared) return map;
  ElevationMap covered = map;
  covered.upper = map.upper.clone();
  cv::add(map.upper, cover.allowance_m, covered.upper, cover.allowance_m > 0.0);
  covered.standard_deviation = map.standard_deviation.clone();
  covered.standard_deviation.setTo(std::numeric_limits<float>::quiet_NaN(), cover.is_unknown);
  covered.is_compared = true;
  return covered;
}

}  // namespace freelsd
