#include "engine/cover/look_alikes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_bands.h"
#include "engine/cover/photo_features.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Side of the squares whose spectra are taken. Squares overlap by half. Averaging neighbours keeps
// rows, which they share, and reduces noise.
constexpr double kSquareM = 12.0;
// Squares with a larger unseen share have no spectrum.
constexpr double kMaxUnseenRatio = 0.2;
// Rings of the spectrum, in rows per metre.
constexpr double kRingStep = 0.1;
constexpr double kRingHalfWidth = 0.08;
// A peak is due to rows if it exceeds, by this factor, the power in its direction at this share of
// its frequency.
constexpr double kInside = 0.7;
constexpr float kMinPeakToLine = 1.0f;
// Least number of squares of a field; a single one may be chance.
constexpr int kMinNumSquares = 4;
constexpr int kMaxGapSquares = 2;
// Directions of rows within one field differ by at most this.
constexpr double kMaxRowTurnRad = RadFromDeg(10.0);
// Squares at the edge of a band see less, so bands overlap by this.
constexpr double kHaloM = 48.0;
// Detail is finer than this. Its strength is measured over squares of this side.
constexpr double kDetailM = 0.5;
constexpr double kDetailSquareM = 6.0;
// Avoids a division by zero: the mean is 0 where nothing is seen.
constexpr double kLeastWeight = 1e-6;

cv::Mat1f Brightness(const Orthophoto& photo) {
  cv::Mat1f brightness;
  cv::Mat1b grey;
  cv::cvtColor(photo.image, grey, cv::COLOR_BGR2GRAY);
  grey.convertTo(brightness, CV_32F);
  return brightness;
}

// Squares in rows and columns over the orthophoto, from its corner on, half a side apart.
struct Squares {
  int side = 0;
  int step = 0;
  int num_rows = 0;
  int num_cols = 0;

  Squares(const cv::Size& size, double side_m, double cell_size_m)
      : side(2 * std::max(4, static_cast<int>(std::lround(0.5 * side_m / cell_size_m)))),
        step(side / 2),
        num_rows(CountAlong(size.height)),
        num_cols(CountAlong(size.width)) {}
  int CountAlong(int length) const { return length < side ? 0 : (length - side) / step + 1; }
  cv::Rect At(int row, int col) const { return {col * step, row * step, side, side}; }
  // The middle part of the square, which belongs to no other square.
  cv::Rect Core(int row, int col) const {
    return {col * step + step / 2, row * step + step / 2, step, step};
  }
};

// Power of the brightness, in units of its variance; empty where too much is unseen.
cv::Mat1f PowerOf(const cv::Mat1f& brightness, const cv::Mat1b& seen, const cv::Mat1f& window) {
  const double num_unseen = static_cast<double>(seen.total()) - cv::countNonZero(seen);
  if (num_unseen > kMaxUnseenRatio * static_cast<double>(seen.total())) return {};
  cv::Scalar mean, deviation;
  cv::meanStdDev(brightness, mean, deviation, seen);
  if (!(deviation[0] > 0.0)) return {};
  cv::Mat1f even = (brightness - mean[0]) / deviation[0];
  even.setTo(0.0f, seen == 0);
  even = even.mul(window);
  cv::Mat spectrum;
  cv::dft(even, spectrum, cv::DFT_COMPLEX_OUTPUT);
  cv::Mat parts[2];
  cv::split(spectrum, parts);
  return cv::Mat1f(parts[0].mul(parts[0]) + parts[1].mul(parts[1]));
}

// Power in the direction of a peak at a lower frequency. A road or wall has more there than at the
// peak, and rows have less.
float PowerInside(const cv::Mat1f& power, const cv::Point& peak) {
  const int side = power.rows;
  const auto u = static_cast<int>(std::lround(kInside * peak.x));
  const auto v = static_cast<int>(std::lround(kInside * peak.y));
  float most = 0.0f;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      most = std::max(most, power((v + dv + side) % side, (u + du + side) % side));
    }
  }
  return most;
}

// Bins of the spectrum with about the same number of rows per metre; x across, y down.
using Ring = std::vector<cv::Point>;

std::vector<Ring> RingsOf(int side, double cell_size_m, const CoverOptions& options) {
  const double finest = std::min(1.0 / options.min_row_spacing_m, 0.48 / cell_size_m);
  std::vector<Ring> rings;
  for (double middle = 1.0 / options.max_row_spacing_m; middle <= finest; middle += kRingStep) {
    Ring ring;
    for (int v = -side / 2; v < side / 2; ++v) {
      for (int u = 0; u < side / 2; ++u) {
        const double rows_per_m = std::hypot(u, v) / (side * cell_size_m);
        if (std::abs(rows_per_m - middle) <= kRingHalfWidth) ring.emplace_back(u, v);
      }
    }
    if (!ring.empty()) rings.push_back(std::move(ring));
  }
  return rings;
}

// The strongest direction of a square, if there is one.
struct Rows {
  // Ratio of the peak to the median of its ring; highest over all rings.
  double strength = 0.0;
  // The same over peaks with less power at lower frequencies, which only rows have.
  double sure_strength = 0.0;
  double direction_rad = 0.0;
};

Rows FindRows(const cv::Mat1f& power, const std::vector<Ring>& rings) {
  const int side = power.rows;
  Rows rows;
  std::vector<float> values;
  for (const Ring& ring : rings) {
    values.clear();
    for (const cv::Point& place : ring) values.push_back(power((place.y + side) % side, place.x));
    const auto largest = std::max_element(values.begin(), values.end());
    const cv::Point peak = ring[static_cast<size_t>(largest - values.begin())];
    const float height = *largest;
    const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), half, values.end());
    if (!(*half > 0.0f)) continue;
    const double strength = height / *half;
    const bool is_sure = height > kMinPeakToLine * PowerInside(power, peak);
    if (is_sure ? strength > rows.sure_strength
                : rows.sure_strength == 0.0 && strength > rows.strength) {
      rows.direction_rad = std::atan2(peak.y, peak.x);
    }
    rows.strength = std::max(rows.strength, strength);
    if (is_sure) rows.sure_strength = std::max(rows.sure_strength, strength);
  }
  return rows;
}

// Mean spectrum of a square and its neighbours; empty where the square has none.
cv::Mat1f MeanAround(const std::vector<cv::Mat1f>& powers,
                     const Squares& squares,
                     int row,
                     int col) {
  const auto at = [&](int r, int c) -> const cv::Mat1f& {
    return powers[static_cast<size_t>(r * squares.num_cols + c)];
  };
  if (at(row, col).empty()) return {};
  cv::Mat1f sum = cv::Mat1f::zeros(squares.side, squares.side);
  for (int r = std::max(0, row - 1); r <= std::min(squares.num_rows - 1, row + 1); ++r) {
    for (int c = std::max(0, col - 1); c <= std::min(squares.num_cols - 1, col + 1); ++c) {
      if (!at(r, c).empty()) sum += at(r, c);
    }
  }
  return sum;
}

// Angle between undirected lines.
double AngleBetween(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, kPi));
}

// Grown rows show one direction without a spacing, like a wall. Beside sure rows of the same
// direction they belong to that field.
cv::Mat1b WithSameRows(const cv::Mat1b& sure,
                       const std::vector<Rows>& found,
                       const CoverOptions& options) {
  cv::Mat1b whole = sure.clone();
  const auto rows_at = [&](const cv::Point& square) -> const Rows& {
    return found[static_cast<size_t>(square.y * sure.cols + square.x)];
  };
  // A square, and the direction of the sure rows it is connected to.
  std::vector<std::pair<cv::Point, double>> open;
  for (int row = 0; row < sure.rows; ++row) {
    for (int col = 0; col < sure.cols; ++col) {
      const cv::Point square(col, row);
      if (sure(square)) open.emplace_back(square, rows_at(square).direction_rad);
    }
  }
  const cv::Rect all({}, sure.size());
  for (size_t i = 0; i < open.size(); ++i) {
    const auto [at, direction_rad] = open[i];
    for (int down = -1; down <= 1; ++down) {
      for (int right = -1; right <= 1; ++right) {
        const cv::Point next = at + cv::Point(right, down);
        if (!all.contains(next) || whole(next)) continue;
        const Rows& rows = rows_at(next);
        if (rows.strength < options.min_row_strength) continue;
        if (AngleBetween(rows.direction_rad, direction_rad) > kMaxRowTurnRad) continue;
        whole(next) = 255;
        open.emplace_back(next, direction_rad);
      }
    }
  }
  return whole;
}

// Closes gaps within a field and extends it to its border, where a square is half
// outside.
cv::Mat1b WholeFields(const cv::Mat1b& squares) {
  const cv::Mat gap = cv::Mat1b::ones(2 * kMaxGapSquares + 1, 2 * kMaxGapSquares + 1);
  cv::Mat1b closed, grown;
  cv::morphologyEx(squares, closed, cv::MORPH_CLOSE, gap);
  cv::dilate(closed, grown, cv::Mat1b::ones(3, 3));
  return grown;
}

// The rows of all squares, row-major.
std::vector<Rows> RowsOfSquares(const Orthophoto& photo,
                                const Squares& squares,
                                const CoverOptions& options) {
  const cv::Mat1f brightness = Brightness(photo);
  cv::Mat1f window;
  cv::createHanningWindow(window, {squares.side, squares.side}, CV_32F);
  std::vector<cv::Mat1f> powers;
  for (int row = 0; row < squares.num_rows; ++row) {
    for (int col = 0; col < squares.num_cols; ++col) {
      const cv::Rect square = squares.At(row, col);
      powers.push_back(PowerOf(brightness(square), photo.seen(square), window));
    }
  }
  const std::vector<Ring> rings = RingsOf(squares.side, photo.grid.cell_size_m, options);
  std::vector<Rows> found;
  found.reserve(powers.size());
  for (int row = 0; row < squares.num_rows; ++row) {
    for (int col = 0; col < squares.num_cols; ++col) {
      const cv::Mat1f power = MeanAround(powers, squares, row, col);
      found.push_back(power.empty() ? Rows{} : FindRows(power, rings));
    }
  }
  return found;
}

// 255 where the views leave room for water.
cv::Mat1b MayBeWater(const ToldKinds& told, const CoverOptions& options) {
  cv::Mat1b may_be = ~cv::Mat1b(told.grass >= options.max_still_water_posterior);
  std::transform(told.other.begin(),
                 told.other.end(),
                 may_be.begin(),
                 may_be.begin(),
                 [](uint8_t other, uint8_t unsure) {
                   const bool is_water = LikelyKind::Unpack(other).kind == GroundKind::kWater;
                   return is_water ? unsure : uint8_t{0};
                 });
  return may_be;
}

}  // namespace

cv::Mat1b RowCrops(const Orthophoto& photo, const CoverOptions& options) {
  const Squares squares(photo.image.size(), kSquareM, photo.grid.cell_size_m);
  cv::Mat1b mask = cv::Mat1b::zeros(photo.image.size());
  if (squares.num_rows == 0 || squares.num_cols == 0) return mask;
  const std::vector<Rows> found = RowsOfSquares(photo, squares, options);
  cv::Mat1b has_rows = cv::Mat1b::zeros(squares.num_rows, squares.num_cols);
  std::transform(found.begin(), found.end(), has_rows.begin(), [&](const Rows& rows) {
    return static_cast<uint8_t>(rows.sure_strength >= options.min_row_strength ? 255 : 0);
  });
  has_rows = WithoutSpecks(has_rows, kMinNumSquares);
  has_rows = WholeFields(WithSameRows(has_rows, found, options));
  for (int row = 0; row < squares.num_rows; ++row) {
    for (int col = 0; col < squares.num_cols; ++col) {
      if (has_rows(row, col)) mask(squares.Core(row, col)).setTo(255);
    }
  }
  return mask;
}

cv::Mat1b StillWater(const Orthophoto& photo, const CoverOptions& options) {
  const double cell = photo.grid.cell_size_m;
  const cv::Mat1f brightness = Brightness(photo);
  cv::Mat1f seen, weight, coarse;
  photo.seen.convertTo(seen, CV_32F, 1.0 / 255.0);
  // Averages seen cells only: edges of holes are no detail, and water has many holes.
  cv::GaussianBlur(brightness.mul(seen), coarse, {}, kDetailM / cell);
  cv::GaussianBlur(seen, weight, {}, kDetailM / cell);
  const cv::Mat1f detail = (brightness - coarse / (weight + kLeastWeight)).mul(seen);
  const auto mean_of = [side = BoxSide(kDetailSquareM / cell)](const cv::Mat1f& values) {
    return BoxMean(values, side, BoxBorder::kMirrored);
  };
  const cv::Mat1f power = mean_of(detail.mul(detail)), share = mean_of(seen);
  const cv::Mat1f level = mean_of(brightness.mul(seen));
  cv::Mat1b mask = cv::Mat1b::zeros(photo.image.size());
  for (int row = 0; row < mask.rows; ++row) {
    for (int col = 0; col < mask.cols; ++col) {
      if (!photo.seen(row, col)) continue;
      const double strength =
          std::sqrt(power(row, col) * share(row, col)) / (level(row, col) + 1.0);
      if (strength < options.min_detail_ratio) mask(row, col) = 255;
    }
  }
  return mask;
}

cv::Mat1b FindLookAlikes(const Orthophoto& photo,
                         const Grid& grid,
                         const ToldKinds& told,
                         const CoverOptions& options) {
  if (photo.image.empty()) return {};
  const auto find = [&](cv::Mat1b (*cue)(const Orthophoto&, const CoverOptions&)) {
    const auto in_band = [&](const PhotoBand& band) { return cue(band.photo, options); };
    return OnMap(FindInBands(photo, kHaloM, in_band), grid);
  };
  cv::Mat1b found = cv::Mat1b::zeros(grid.num_rows, grid.num_cols);
  if (options.min_row_strength > 0.0)
    found |= find(RowCrops) & (told.grass < options.max_row_posterior);
  if (options.min_detail_ratio > 0.0) found |= find(StillWater) & MayBeWater(told, options);
  return found;
}

}  // namespace freelsd
