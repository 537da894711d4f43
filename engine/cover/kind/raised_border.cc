#include "engine/cover/kind/raised_border.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/geometry.h"

namespace freelsd {
namespace {

// Narrower necks are cut: a gap in a hedge does not join two fields.
constexpr double kNeckM = 5.0;
// Deviation of the blur of the field's outline, which gives the direction of its border.
constexpr double kOutlineM = 2.0;
// Heights across a border are used up to this far inside and outside.
constexpr double kInnerEndM = 7.0;
constexpr double kOuterEndM = 9.0;
constexpr int kMinNumHeights = 4;
// A border is raised where its step in height is at least this.
constexpr double kMinRaisedStepM = 0.6;
// Fields of which less border is known are not told.
constexpr double kMinKnownBorderM = 30.0;
// The step is known if two planes of one slope, one on each side, fit this well.
constexpr double kMaxResidualM = 0.25;
// A strip of this width outside is left out, because stereo turns the step into a ramp.
constexpr double kRampM = 3.0;

struct Border {
  double raised_m = 0.0;
  double known_m = 0.0;
};

// A height near a border, with its distance outwards.
struct HeightBeside {
  double distance = 0.0;
  double height = 0.0;
  bool is_inside = false;
};
using CrossSection = std::vector<HeightBeside>;

bool IsEnough(const CrossSection& section) {
  const auto num_inside = std::count_if(
      section.begin(), section.end(), [](const auto& each) { return each.is_inside; });
  return num_inside >= kMinNumHeights && std::ssize(section) - num_inside >= kMinNumHeights;
}

// Height of the inside above the outside, with planes of one slope fitted to both sides; nothing
// where the planes do not fit.
std::optional<double> StepOf(const CrossSection& section) {
  const Eigen::Index n = std::ssize(section);
  Eigen::MatrixX3d design(n, 3);
  Eigen::VectorXd height(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const HeightBeside& each = section[static_cast<size_t>(i)];
    design.row(i) << 1.0, each.distance, each.is_inside ? 1.0 : 0.0;
    height[i] = each.height;
  }
  const Eigen::Vector3d fit = design.colPivHouseholderQr().solve(height);
  const double residual = std::sqrt((design * fit - height).squaredNorm() / static_cast<double>(n));
  if (residual > kMaxResidualM) return std::nullopt;
  return fit[2];
}

// Holes are filled: a pond within a meadow lies lower, but the meadow around it is not raised.
cv::Mat1b WithoutHoles(const cv::Mat1b& cells) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(cells, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::Mat1b filled = cv::Mat1b::zeros(cells.size());
  cv::drawContours(filled, outlines, -1, cv::Scalar::all(255.0), cv::FILLED);
  return filled;
}

class Field {
 public:
  Field(const cv::Mat1b& cells, const cv::Mat1f& elevation, double cell_size_m)
      : cells_(cells), elevation_(elevation), cell_(cell_size_m) {
    cv::Mat1f outline;
    cells.convertTo(outline, CV_32F, 1.0 / 255.0);
    cv::GaussianBlur(outline, outline, {}, kOutlineM / cell_size_m, 0.0, cv::BORDER_CONSTANT);
    cv::Sobel(outline, east_, CV_32F, 1, 0);
    cv::Sobel(outline, south_, CV_32F, 0, 1);
  }

  Border Measure() const {
    Border border;
    for (int row = 0; row < cells_.rows; ++row) {
      for (int col = 0; col < cells_.cols; ++col) {
        if (!IsBorder(row, col)) continue;
        const CrossSection section = Across(row, col);
        if (!IsEnough(section)) continue;
        const std::optional<double> step = StepOf(section);
        if (!step) continue;
        border.known_m += cell_;
        if (*step >= kMinRaisedStepM) border.raised_m += cell_;
      }
    }
    return border;
  }

 private:
  bool IsInside(int row, int col) const {
    return row >= 0 && row < cells_.rows && col >= 0 && col < cells_.cols && cells_(row, col) != 0;
  }
  bool IsBorder(int row, int col) const {
    return IsInside(row, col) && !(IsInside(row - 1, col) && IsInside(row + 1, col) &&
                                   IsInside(row, col - 1) && IsInside(row, col + 1));
  }

  CrossSection Across(int row, int col) const {
    CrossSection section;
    const Eigen::Vector2d inwards(east_(row, col), south_(row, col));
    if (!(inwards.norm() > 0.0)) return section;
    const Eigen::Vector2d outwards = -inwards.normalized();
    for (double d = -kInnerEndM; d <= kOuterEndM; d += cell_) {
      if (d > 0.0 && d < kRampM) continue;
      const int r = row + static_cast<int>(std::lround(d * outwards.y() / cell_));
      const int c = col + static_cast<int>(std::lround(d * outwards.x() / cell_));
      if (r < 0 || r >= cells_.rows || c < 0 || c >= cells_.cols) continue;
      const bool is_inside = d <= 0.0;
      if (IsInside(r, c) != is_inside || std::isnan(elevation_(r, c))) continue;
      section.push_back({d, elevation_(r, c), is_inside});
    }
    return section;
  }

  cv::Mat1b cells_;
  cv::Mat1f elevation_;
  double cell_;
  cv::Mat1f east_, south_;
};

}  // namespace

cv::Mat1f RaisedBorderRatio(const cv::Mat1b& is_even,
                            const cv::Mat1f& elevation,
                            double cell_size_m) {
  const int neck = 2 * static_cast<int>(0.5 * kNeckM / cell_size_m) + 1;
  cv::Mat1b wide;
  cv::morphologyEx(is_even != 0,
                   wide,
                   cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {neck, neck}));
  cv::Mat1i labels, boxes;
  cv::Mat1d middles;
  const int num_labels = cv::connectedComponentsWithStats(wide, labels, boxes, middles, 4, CV_32S);
  const int halo = static_cast<int>(std::ceil(kOuterEndM / cell_size_m)) + 1;
  cv::Mat1f ratio(is_even.size(), std::numeric_limits<float>::quiet_NaN());
  for (int label = 1; label < num_labels; ++label) {
    cv::Rect box(boxes(label, cv::CC_STAT_LEFT) - halo,
                 boxes(label, cv::CC_STAT_TOP) - halo,
                 boxes(label, cv::CC_STAT_WIDTH) + 2 * halo,
                 boxes(label, cv::CC_STAT_HEIGHT) + 2 * halo);
    box &= cv::Rect({}, is_even.size());
    const cv::Mat1b cells = labels(box) == label;
    const Border border = Field(WithoutHoles(cells), elevation(box), cell_size_m).Measure();
    if (border.known_m < kMinKnownBorderM) continue;
    ratio(box).setTo(border.raised_m / border.known_m, cells);
  }
  return ratio;
}

}  // namespace freelsd
