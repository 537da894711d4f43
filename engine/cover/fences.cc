#include "engine/cover/fences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/cover/photo_bands.h"
#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

constexpr int kNumDirections = 48;
// A line is tested in pieces. All but one must be dark: a bush is no line, and a fence may have a
// gate.
constexpr int kNumPieces = 4;
// A cell is compared with its surroundings of this size and with the cells at this distance beside
// it.
constexpr double kSurroundingsM = 3.0;
constexpr double kBesideM = 1.0;
// Share of a piece that must be meadow.
constexpr float kMinMeadowRatio = 0.6f;
// A post or line may interrupt the meadow by a gap of this width.
constexpr double kGapM = 3.0;
// Posts are this far apart. At this distance from a post, a line is at most this share as dark.
constexpr double kApartM = 0.75;
constexpr float kMaxDarknessApart = 0.5f;
// Every n-th cell is sampled to measure the darkness of lines where there is no fence.
constexpr int kSampleStep = 9;
// Median absolute value of a normal distribution, in deviations.
constexpr float kMedianDeviation = 0.6745f;
// No orthophoto is more even than this, as a share of the brightness.
constexpr float kLeastDeviation = 1e-3f;
// Added to brightness before its logarithm is taken: the noise of a dark cell.
constexpr float kDarkNoise = 12.0f;

struct Darkness {
  // Logarithm of the brightness; 0 where it does not count.
  cv::Mat1f brightness;
  // Brightness of the surroundings minus that of the cell; 0 where it does not count.
  cv::Mat1f value;
  // 1 or 0.
  cv::Mat1f counts;
};

Darkness DarknessOf(const Orthophoto& photo, const cv::Mat1b& is_meadow) {
  cv::Mat1f brightness(photo.image.size(), 0.0f), counts(photo.image.size(), 0.0f);
  for (int row = 0; row < counts.rows; ++row) {
    for (int col = 0; col < counts.cols; ++col) {
      if (!photo.seen(row, col) || !is_meadow(row, col)) continue;
      const cv::Vec3b& bgr = photo.image(row, col);
      counts(row, col) = 1.0f;
      brightness(row, col) = std::log(static_cast<float>(bgr[0] + bgr[1] + bgr[2]) + kDarkNoise);
    }
  }
  const int side = BoxSide(kSurroundingsM / photo.grid.cell_size_m);
  const cv::Mat1f around = BoxMean(brightness, side, BoxBorder::kNothing);
  const cv::Mat1f share = BoxMean(counts, side, BoxBorder::kNothing);
  Darkness darkness{brightness, cv::Mat1f(counts.size(), 0.0f), counts};
  for (int row = 0; row < counts.rows; ++row) {
    for (int col = 0; col < counts.cols; ++col) {
      if (counts(row, col) == 0.0f) continue;
      darkness.value(row, col) = around(row, col) / share(row, col) - brightness(row, col);
    }
  }
  return darkness;
}

float DeviationOf(std::vector<float> values) {
  if (values.empty()) return std::numeric_limits<float>::infinity();
  for (float& value : values) value = std::abs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return std::max(kLeastDeviation, *middle / kMedianDeviation);
}

// Tests lines through one cell. The offsets of their cells are the same for every cell.
class FenceFilter {
 public:
  FenceFilter(const Darkness& darkness, double cell_size_m, const CoverOptions& options)
      : min_num_posts_(options.min_num_posts),
        num_cells_apart_(static_cast<int>(kApartM / cell_size_m)) {
    const double half_m = 0.5 * options.fence_filter_length_m;
    margin_ = static_cast<int>(std::ceil((half_m + kBesideM) / cell_size_m)) + 2;
    const auto framed = [this](const cv::Mat1f& values) {
      cv::Mat1f wider;
      cv::copyMakeBorder(
          values, wider, margin_, margin_, margin_, margin_, cv::BORDER_CONSTANT, cv::Scalar(0.0));
      return wider;
    };
    brightness_ = framed(darkness.brightness);
    value_ = framed(darkness.value);
    counts_ = framed(darkness.counts);
    const int num_cells =
        std::max(1, static_cast<int>(options.fence_filter_length_m / kNumPieces / cell_size_m));
    for (size_t i = 0; i < directions_.size(); ++i) {
      const double angle = kPi * static_cast<double>(i) / kNumDirections;
      const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d across(-along.y(), along.x());
      for (int piece = 0; piece < kNumPieces; ++piece) {
        for (int cell = 0; cell < num_cells; ++cell) {
          const double step = (piece - 0.5 * kNumPieces) * num_cells + cell + 0.5;
          directions_[i].pieces[static_cast<size_t>(piece)].push_back(OffsetOf(along * step));
        }
      }
      directions_[i].beside = OffsetOf(across * (kBesideM / cell_size_m));
      directions_[i].apart = OffsetOf(along * (kApartM / cell_size_m));
      directions_[i].next = OffsetOf(across);
      directions_[i].half_line = along * (0.5 * kNumPieces * num_cells);
    }
    MeasureNoise(options);
  }

  // Dark lines with posts, in an orthophoto of this size.
  cv::Mat1b Lines(const cv::Size& size) const {
    cv::Mat1b lines(size, uint8_t{0});
    for (int row = 0; row < size.height; ++row) {
      const float* cell = value_[row + margin_] + margin_;
      for (int col = 0; col < size.width; ++col, ++cell) {
        if (*cell < least_post_) continue;
        for (const Direction& direction : directions_) {
          if (!IsDarkLine(cell, direction)) continue;
          const Eigen::Vector2d middle(col, row);
          const Eigen::Vector2d begin = middle - direction.half_line;
          const Eigen::Vector2d end = middle + direction.half_line;
          cv::line(lines, PixelAt(begin), PixelAt(end), cv::Scalar(255));
        }
      }
    }
    return lines;
  }

 private:
  // Offsets of the piece's cells from the tested cell.
  using Piece = std::vector<std::ptrdiff_t>;
  struct Direction {
    std::array<Piece, kNumPieces> pieces;
    // Across the line: offsets of the cells that must be brighter, and of the next cell. Along the
    // line: offset beyond a post.
    std::ptrdiff_t beside = 0;
    std::ptrdiff_t next = 0;
    std::ptrdiff_t apart = 0;
    Eigen::Vector2d half_line = Eigen::Vector2d::Zero();
  };

  static cv::Point PixelAt(const Eigen::Vector2d& place) {
    return {static_cast<int>(std::lround(place.x())), static_cast<int>(std::lround(place.y()))};
  }

  std::ptrdiff_t OffsetOf(const Eigen::Vector2d& step) const {
    return std::lround(step.y()) * static_cast<std::ptrdiff_t>(value_.step1()) +
           std::lround(step.x());
  }

  static float Mean(const float* middle, const Piece& piece) {
    float sum = 0.0f;
    for (const std::ptrdiff_t offset : piece) sum += middle[offset];
    return sum / static_cast<float>(piece.size());
  }

  float MeadowRatio(const float* cell, const Piece& piece) const {
    return Mean(counts_[0] + (cell - value_[0]), piece);
  }

  // Mean over the meadow cells of the piece; NaN if there are too few.
  float Brightness(const float* cell, const Piece& piece) const {
    const float ratio = MeadowRatio(cell, piece);
    if (ratio < kMinMeadowRatio) return std::numeric_limits<float>::quiet_NaN();
    return Mean(brightness_[0] + (cell - value_[0]), piece) / ratio;
  }

  // Darker than the surroundings and than both sides. Beside a path or at the edge of a shadow the
  // surroundings are brighter on one side only.
  bool IsDark(const float* cell, const Piece& piece, std::ptrdiff_t beside) const {
    if (Mean(cell, piece) < least_line_) return false;
    const float brightness = Brightness(cell, piece);
    return Brightness(cell + beside, piece) - brightness >= least_line_ &&
           Brightness(cell - beside, piece) - brightness >= least_line_;
  }

  // Darkest cell across the line: posts do not stand exactly on it.
  static float DarkestAcross(const float* cell, std::ptrdiff_t next) {
    return std::max({cell[0], cell[next], cell[-next]});
  }

  bool IsPost(const float* cell, const Direction& direction) const {
    const float darkness = DarkestAcross(cell, direction.next);
    if (darkness < least_post_) return false;
    const float apart = std::max(DarkestAcross(cell + direction.apart, direction.next),
                                 DarkestAcross(cell - direction.apart, direction.next));
    return apart <= kMaxDarknessApart * darkness;
  }

  // A track, a furrow or the edge of a swath is as dark all along; posts stand apart.
  bool HasPosts(const float* cell, const Direction& direction) const {
    int num_posts = 0, num_cells_since = num_cells_apart_;
    for (const Piece& piece : direction.pieces) {
      for (const std::ptrdiff_t offset : piece) {
        ++num_cells_since;
        if (num_cells_since <= num_cells_apart_ || !IsPost(cell + offset, direction)) continue;
        ++num_posts;
        num_cells_since = 0;
      }
    }
    return num_posts >= min_num_posts_;
  }

  // The first pieces reject most lines.
  bool IsDarkLine(const float* cell, const Direction& direction) const {
    int num_missing = 0;
    for (const Piece& piece : direction.pieces) {
      num_missing += !IsDark(cell, piece, direction.beside);
      if (num_missing > 1) return false;
    }
    return HasPosts(cell, direction);
  }

  // Noise of single cells, and of pieces of lines anywhere.
  void MeasureNoise(const CoverOptions& options) {
    std::vector<float> cells, pieces;
    for (int row = margin_; row < value_.rows - margin_; row += kSampleStep) {
      for (int col = margin_; col < value_.cols - margin_; col += kSampleStep) {
        const float* cell = value_[row] + col;
        if (counts_(row, col) == 0.0f) continue;
        cells.push_back(*cell);
        for (const size_t i : {size_t{0}, directions_.size() / 3, 2 * directions_.size() / 3}) {
          const Piece& piece = directions_[i].pieces[kNumPieces / 2];
          if (MeadowRatio(cell, piece) >= 1.0f) pieces.push_back(Mean(cell, piece));
        }
      }
    }
    least_post_ = static_cast<float>(options.min_post_deviations) * DeviationOf(std::move(cells));
    least_line_ = static_cast<float>(options.min_fence_deviations) * DeviationOf(std::move(pieces));
  }

  int min_num_posts_;
  int num_cells_apart_;
  int margin_ = 0;
  cv::Mat1f brightness_, value_, counts_;
  std::array<Direction, kNumDirections> directions_;
  // Least darkness of a post's cell, and of a piece of a line.
  float least_post_ = 0.0f;
  float least_line_ = 0.0f;
};

}  // namespace

cv::Mat1b FindFences(const Orthophoto& photo,
                     const cv::Mat1b& is_meadow,
                     const Grid& grid,
                     const CoverOptions& options) {
  cv::Mat1b whole, meadow;
  const int gap = 2 * static_cast<int>(0.5 * kGapM / grid.cell_size_m) + 1;
  cv::morphologyEx(is_meadow,
                   whole,
                   cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_RECT, cv::Size(gap, gap)));
  cv::resize(whole, meadow, photo.image.size(), 0.0, 0.0, cv::INTER_NEAREST);
  const auto find = [&](const PhotoBand& band) {
    const cv::Range rows(band.photo_first_row, band.photo_first_row + band.photo.image.rows);
    const Darkness darkness = DarknessOf(band.photo, meadow.rowRange(rows));
    const FenceFilter filter(darkness, photo.grid.cell_size_m, options);
    return filter.Lines(band.photo.image.size());
  };
  return OnMap(FindInBands(photo, 1.5 * options.fence_filter_length_m, find), grid);
}

}  // namespace freelsd
