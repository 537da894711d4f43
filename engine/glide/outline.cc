#include "engine/glide/outline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <unordered_map>

#include "engine/glide/corner_rings.h"

namespace freelsd {
namespace {

// Smaller areas are left out, in cells.
constexpr double kMinArea = 8.0;
// Greatest distance from a cut to the corners that it cuts off, in cells. Below 2, no hole fits
// between them.
constexpr double kMaxCut = 1.5;
// Corners that one cut may cut off, and corners tried beyond the last possible cut.
constexpr size_t kMaxNumCutOff = 100;
constexpr size_t kNumTriedBeyond = 6;
// Of the possible cuts from one corner, the longest first.
constexpr int kNumTriedCuts = 3;

// Positive if the offset points to the left of the way, with north up. Rows grow to the south.
double Side(const cv::Point& way, const cv::Point& offset) {
  return static_cast<double>(static_cast<int64_t>(way.y) * offset.x -
                             static_cast<int64_t>(way.x) * offset.y);
}

// In cells; positive for an outer ring.
double EnclosedBy(const CornerRing& ring) {
  double twice = 0.0;
  for (size_t i = 0; i < ring.size(); ++i) twice += Side(ring[i], ring[(i + 1) % ring.size()]);
  return 0.5 * twice;
}

// Replaces parts of rings by straight cuts. Cuts run through cells of the area only, and no two of
// them through the same cell unless they follow each other: so none cross.
class Cutter {
 public:
  explicit Cutter(const cv::Mat1b& cells) : cells_(cells) {}

  CornerRing Cut(const CornerRing& ring) {
    CornerRing result;
    previous_cut_ = kNoCut;
    for (size_t at = 0; at < ring.size();) {
      result.push_back(ring[at]);
      at = NextAfter(ring, at);
    }
    return result;
  }

 private:
  static constexpr size_t kNoCut = 0;

  // Index of the next corner to keep; the ring's size stands for its first corner.
  size_t NextAfter(const CornerRing& ring, size_t from) {
    std::vector<size_t> possible;
    const size_t last = std::min(ring.size(), from + kMaxNumCutOff);
    size_t num_missed = 0;
    for (size_t to = from + 2; to <= last && num_missed < kNumTriedBeyond; ++to) {
      const bool is_inwards = CutsInwards(ring, from, to);
      if (is_inwards) possible.push_back(to);
      num_missed = is_inwards ? 0 : num_missed + 1;
    }
    for (int i = 0; i < kNumTriedCuts && !possible.empty(); ++i, possible.pop_back()) {
      if (!IsFree(ring, from, possible.back())) continue;
      previous_cut_ = ++num_cuts_;
      for (const int64_t cell : cut_cells_) cut_by_cell_[cell] = num_cuts_;
      return possible.back();
    }
    previous_cut_ = kNoCut;
    return from + 1;
  }

  // Whether the cut takes away from the area, and not too much.
  static bool CutsInwards(const CornerRing& ring, size_t from, size_t to) {
    const cv::Point& a = ring[from];
    const cv::Point way = ring[to % ring.size()] - a;
    const double squared = static_cast<double>(way.dot(way));
    if (squared == 0.0) return false;
    for (size_t i = from + 1; i < to; ++i) {
      const cv::Point offset = ring[i] - a;
      const double side = Side(way, offset);
      if (side > 0.0 || side * side > kMaxCut * kMaxCut * squared) return false;
      const double along = static_cast<double>(offset.dot(way));
      if (along < 0.0 || along > squared) return false;
    }
    return true;
  }

  // Whether the cut runs through free cells of the area only. Leaves them in cut_cells_.
  bool IsFree(const CornerRing& ring, size_t from, size_t to) {
    cut_cells_.clear();
    const cv::Point& end = ring[to % ring.size()];
    const cv::Point way = end - ring[from];
    // Corners of the ring on the cut divide it.
    cv::Point begin = ring[from];
    for (size_t i = from + 1; i < to; ++i) {
      if (Side(way, ring[i] - ring[from]) != 0.0) continue;
      if (!IsPieceFree(begin, ring[i])) return false;
      begin = ring[i];
    }
    return IsPieceFree(begin, end);
  }

  bool IsPieceFree(const cv::Point& begin, const cv::Point& end) {
    const cv::Point way = end - begin;
    const int num_steps = std::gcd(std::abs(way.x), std::abs(way.y));
    if (num_steps == 0) return false;
    const cv::Point step(way.x / num_steps, way.y / num_steps);
    const bool is_along_cells = way.x == 0 || way.y == 0;
    cv::Point at = begin;
    for (int i = 0; i < num_steps; ++i, at += step) {
      if (is_along_cells) {
        if (!AddLeftOf(at, step)) return false;
      } else if ((i > 0 && !IsSurrounded(at)) || !AddAcross(at, step)) {
        return false;
      }
    }
    return true;
  }

  // The cell to the left of a step along the edge of cells.
  bool AddLeftOf(const cv::Point& at, const cv::Point& step) {
    const int col = step.x > 0 || step.y > 0 ? at.x : at.x - 1;
    const int row = step.x < 0 || step.y > 0 ? at.y : at.y - 1;
    return AddCell(col, row);
  }

  // The cells across which a step from corner to corner runs. Its two parts have no common divisor,
  // so it meets no corner between.
  bool AddAcross(const cv::Point& at, const cv::Point& step) {
    const int num_cols = std::abs(step.x), num_rows = std::abs(step.y);
    const int towards_x = step.x > 0 ? 1 : -1, towards_y = step.y > 0 ? 1 : -1;
    int col = step.x > 0 ? at.x : at.x - 1, row = step.y > 0 ? at.y : at.y - 1;
    int passed_cols = 1, passed_rows = 1;
    while (true) {
      if (!AddCell(col, row)) return false;
      if (passed_cols == num_cols && passed_rows == num_rows) return true;
      if (static_cast<int64_t>(passed_cols) * num_rows <
          static_cast<int64_t>(passed_rows) * num_cols) {
        col += towards_x;
        ++passed_cols;
      } else {
        row += towards_y;
        ++passed_rows;
      }
    }
  }

  bool IsInside(int col, int row) const {
    return col >= 0 && row >= 0 && col < cells_.cols && row < cells_.rows && cells_(row, col) != 0;
  }

  bool IsSurrounded(const cv::Point& corner) const {
    return IsInside(corner.x, corner.y) && IsInside(corner.x - 1, corner.y) &&
           IsInside(corner.x, corner.y - 1) && IsInside(corner.x - 1, corner.y - 1);
  }

  // False if the cell is not of the area, or if another cut runs through it.
  bool AddCell(int col, int row) {
    if (!IsInside(col, row)) return false;
    const int64_t cell = static_cast<int64_t>(row) * cells_.cols + col;
    const auto found = cut_by_cell_.find(cell);
    if (found != cut_by_cell_.end() && found->second != previous_cut_) return false;
    cut_cells_.push_back(cell);
    return true;
  }

  const cv::Mat1b& cells_;
  std::unordered_map<int64_t, size_t> cut_by_cell_;
  std::vector<int64_t> cut_cells_;
  size_t num_cuts_ = kNoCut;
  // The cut that ends where the next one begins.
  size_t previous_cut_ = kNoCut;
};

Polygon InWorld(const CornerRing& ring, const Grid& grid) {
  Polygon polygon;
  polygon.reserve(ring.size());
  for (const cv::Point& corner : ring) {
    polygon.push_back(grid.north_west_in_world +
                      grid.cell_size_m * Eigen::Vector2d(corner.x, -corner.y));
  }
  return polygon;
}

}  // namespace

std::vector<ReachArea> OutlinesOf(cv::Mat1b cells, const Grid& grid) {
  ClearTouchingCorners(cells);
  Cutter cutter(cells);
  std::vector<ReachArea> areas;
  for (const CornerRings& rings : RingsOf(cells)) {
    // Cuts may leave nothing of a thin area.
    const CornerRing outer = cutter.Cut(rings.front());
    if (EnclosedBy(outer) < kMinArea) continue;
    ReachArea area{InWorld(outer, grid), {}};
    for (size_t i = 1; i < rings.size(); ++i) {
      area.holes.push_back(InWorld(cutter.Cut(rings[i]), grid));
    }
    areas.push_back(std::move(area));
  }
  std::stable_sort(areas.begin(), areas.end(), [](const ReachArea& a, const ReachArea& b) {
    return SignedArea(a.outer) > SignedArea(b.outer);
  });
  return areas;
}

}  // namespace freelsd
