#include "engine/glide/corner_rings.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace freelsd {
namespace {

constexpr int kNone = -1;

// The edge of a run of cells in one row: its column, and the corner at which the vertical line of
// such edges begins.
struct RunEdge {
  int col = 0;
  int top_corner = kNone;
};

// Beginnings and ends of the runs in a row alternate.
using RowEdges = std::vector<RunEdge>;

RowEdges EdgesOf(const cv::Mat1b& cells, int row) {
  RowEdges edges;
  const uchar* const values = cells.ptr(row);
  bool is_inside = false;
  for (int col = 0; col < cells.cols;) {
    if (!is_inside) {
      // Most of a row is empty or full.
      uint64_t eight = 0;
      if (col + 8 <= cells.cols) {
        std::memcpy(&eight, values + col, sizeof(eight));
        if (eight == 0) {
          col += 8;
          continue;
        }
      }
    }
    if ((values[col] != 0) != is_inside) {
      is_inside = !is_inside;
      edges.push_back({col, kNone});
    }
    ++col;
  }
  if (is_inside) edges.push_back({cells.cols, kNone});
  return edges;
}

struct Corner {
  cv::Point place;
  // The next corner along the row, and along the column.
  int beside = kNone;
  int above_or_below = kNone;
  // Of the edge along the row.
  bool is_area_below = false;
  int ring = kNone;
};

struct Ring {
  CornerRing corners;
  // The topmost edge has the area below it.
  bool is_outer = false;
  // The ring to the west of a hole's topmost edge, in the row above.
  int west = kNone;
  int area = kNone;
};

class RingTracer {
 public:
  explicit RingTracer(const cv::Mat1b& cells) {
    rows_.reserve(static_cast<size_t>(cells.rows));
    RowEdges above;
    for (int row = 0; row < cells.rows; ++row) {
      RowEdges edges = EdgesOf(cells, row);
      Connect(row, above, edges);
      rows_.push_back(edges);
      above = std::move(edges);
    }
    RowEdges none;
    Connect(cells.rows, above, none);
  }

  std::vector<CornerRings> Trace() {
    // Corners are in the order of rows and columns, so each ring is found at its topmost edge.
    for (size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i].ring == kNone) AddRing(static_cast<int>(i));
    }
    std::vector<CornerRings> areas;
    for (Ring& ring : rings_) {
      if (ring.is_outer) {
        ring.area = static_cast<int>(areas.size());
        areas.emplace_back();
      } else {
        ring.area = rings_[static_cast<size_t>(ring.west)].area;
      }
      areas[static_cast<size_t>(ring.area)].push_back(std::move(ring.corners));
    }
    return areas;
  }

 private:
  Corner& At(int corner) { return corners_[static_cast<size_t>(corner)]; }

  int AddCorner(int row, int col) {
    Corner corner;
    corner.place = {col, row};
    corners_.push_back(corner);
    return static_cast<int>(corners_.size()) - 1;
  }

  // The line between two rows: where both have an edge, a vertical line goes on. The other edges
  // make corners, and pairs of corners are joined.
  void Connect(int row, const RowEdges& above, RowEdges& below) {
    size_t i = 0, j = 0;
    int open = kNone;
    while (i < above.size() || j < below.size()) {
      const bool is_above = j >= below.size() || (i < above.size() && above[i].col <= below[j].col);
      const bool is_below = i >= above.size() || (j < below.size() && below[j].col <= above[i].col);
      if (is_above && is_below) {
        below[j++].top_corner = above[i++].top_corner;
        continue;
      }
      const int corner = AddCorner(row, is_above ? above[i].col : below[j].col);
      if (is_above) {
        At(corner).above_or_below = above[i].top_corner;
        At(above[i].top_corner).above_or_below = corner;
        ++i;
      } else {
        below[j++].top_corner = corner;
      }
      if (open == kNone) {
        open = corner;
        // Between this corner and the next, one of the two rows is inside the area.
        At(corner).is_area_below = j % 2 == 1;
      } else {
        At(open).beside = corner;
        At(corner).beside = open;
        open = kNone;
      }
    }
  }

  void AddRing(int first) {
    const int index = static_cast<int>(rings_.size());
    Ring ring;
    ring.is_outer = At(first).is_area_below;
    const cv::Point place = At(first).place;
    if (!ring.is_outer) ring.west = RingWestOf(place.y - 1, place.x);
    // Along a topmost edge with the area below, the area is to the left when flown to the west.
    bool is_along_row = !ring.is_outer;
    int corner = first;
    do {
      ring.corners.push_back(At(corner).place);
      At(corner).ring = index;
      corner = is_along_row ? At(corner).beside : At(corner).above_or_below;
      is_along_row = !is_along_row;
    } while (corner != first);
    rings_.push_back(std::move(ring));
  }

  // Ring of the beginning of the run that holds the cell.
  int RingWestOf(int row, int col) {
    const RowEdges& edges = rows_[static_cast<size_t>(row)];
    const auto after = std::upper_bound(
        edges.begin(), edges.end(), col, [](int c, const RunEdge& edge) { return c < edge.col; });
    return At(std::prev(after)->top_corner).ring;
  }

  std::vector<RowEdges> rows_;
  std::vector<Corner> corners_;
  std::vector<Ring> rings_;
};

// True if it cleared a cell of the lower row.
bool ClearBelow(cv::Mat1b& cells, int row) {
  bool is_changed = false;
  const RowEdges above = EdgesOf(cells, row - 1);
  const RowEdges below = EdgesOf(cells, row);
  size_t j = 0;
  for (size_t i = 0; i < above.size(); ++i) {
    while (j < below.size() && below[j].col < above[i].col) ++j;
    const bool touches =
        j < below.size() && below[j].col == above[i].col && (i % 2 == 0) != (j % 2 == 0);
    if (!touches) continue;
    // A beginning below: the run begins one later. An end below: it ends one earlier.
    cells(row, j % 2 == 0 ? below[j].col : below[j].col - 1) = 0;
    is_changed = true;
  }
  return is_changed;
}

}  // namespace

void ClearTouchingCorners(cv::Mat1b& cells) {
  // Clearing in a row may make cells of the row above touch its other cells.
  for (int row = 1; row < cells.rows;) {
    if (ClearBelow(cells, row)) continue;
    ++row;
  }
}

std::vector<CornerRings> RingsOf(const cv::Mat1b& cells) { return RingTracer(cells).Trace(); }

}  // namespace freelsd
