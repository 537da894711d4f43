#include "server/recall/reach/reach_obstacles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "server/recall/emergency_request.h"
#include "server/recall/recall_candidates.h"

namespace freelsd {
namespace {

// No grid reaches farther from the aircraft, to its corners.
constexpr double kFarM = 1.5 * kMaxReachM;

// A point of an obstacle: x is the column, y the row, z the altitude of the top in the request's
// datum, or NaN.
using Top = Eigen::Vector3d;

class Raiser {
 public:
  Raiser(NearbyGround& nearby, double reach_m, double height_above_ground_m)
      : ground_(nearby.ground),
        unmapped_top_m_(nearby.assumed_altitude_m + height_above_ground_m),
        reach_cells_(reach_m / ground_.grid.cell_size_m + kHalfDiagonalOfCell) {}

  // In each row, the columns from the leftmost to the rightmost that the leg may reach.
  void AddLeg(const Top& begin, const Top& end) {
    const Top& upper = begin.y() < end.y() ? begin : end;
    const Top& lower = begin.y() < end.y() ? end : begin;
    const int first = RowWithin(std::floor(upper.y() - reach_cells_));
    const int last = RowWithin(std::floor(lower.y() + reach_cells_));
    for (int row = first; row <= last; ++row) {
      const double middle = row + 0.5;
      const Top a = Along(upper, lower, middle - reach_cells_);
      const Top b = Along(upper, lower, middle + reach_cells_);
      const double west = std::min(a.x(), b.x()) - reach_cells_;
      const double east = std::max(a.x(), b.x()) + reach_cells_;
      if (east < 0.0 || west >= ground_.grid.num_cols) continue;
      const int last_col = ColWithin(std::floor(east));
      const double top_m = std::fmax(a.z(), b.z());
      for (int col = ColWithin(std::floor(west)); col <= last_col; ++col) Raise(row, col, top_m);
    }
  }

  void AddInside(const std::vector<Top>& ring, double top_m) {
    std::vector<cv::Point> corners;
    corners.reserve(ring.size());
    for (const Top& corner : ring) {
      corners.emplace_back(static_cast<int>(std::floor(corner.x())),
                           static_cast<int>(std::floor(corner.y())));
    }
    const cv::Rect box =
        cv::boundingRect(corners) & cv::Rect(0, 0, ground_.grid.num_cols, ground_.grid.num_rows);
    if (box.empty()) return;
    cv::Mat1b inside(box.size(), uchar{0});
    cv::fillPoly(inside, std::vector{corners}, 255, cv::LINE_8, 0, -box.tl());
    for (int row = 0; row < box.height; ++row) {
      for (int col = 0; col < box.width; ++col) {
        if (inside(row, col) != 0) Raise(box.y + row, box.x + col, top_m);
      }
    }
  }

 private:
  static constexpr double kHalfDiagonalOfCell = 0.71;

  int RowWithin(double row) const {
    return static_cast<int>(std::clamp(row, 0.0, ground_.grid.num_rows - 1.0));
  }
  int ColWithin(double col) const {
    return static_cast<int>(std::clamp(col, 0.0, ground_.grid.num_cols - 1.0));
  }
  // The leg where it has this row, or its nearer end.
  static Top Along(const Top& upper, const Top& lower, double row) {
    const double rows = lower.y() - upper.y();
    const double ratio =
        rows > 0.0 ? std::clamp((row - upper.y()) / rows, 0.0, 1.0) : (row < upper.y() ? 0.0 : 1.0);
    return upper + ratio * (lower - upper);
  }
  void Raise(int row, int col, double top_m) {
    float& top = ground_.top(row, col);
    const double least_m = ground_.is_known(row, col) == 0 ? unmapped_top_m_ : top;
    top = std::max(top, static_cast<float>(std::fmax(top_m, least_m)));
  }

  ReachGround& ground_;
  // Of the obstacle where no map is.
  double unmapped_top_m_;
  double reach_cells_;
};

// Columns and rows of the grid.
std::vector<Top> OnGrid(const HardObstacle& obstacle,
                        const LocalFrame& local_frame,
                        const ReachFrame& frame,
                        const Grid& grid) {
  std::vector<Top> tops;
  for (const Eigen::Vector3d& point : obstacle.points_in_world) {
    const bool has_top = !std::isnan(point.z());
    const GeoPoint geo =
        local_frame.GeoFromWorld({point.x(), point.y(), has_top ? point.z() : 0.0});
    const Eigen::Vector2d place =
        (frame.FromGeo(geo) - grid.north_west_in_world) / grid.cell_size_m;
    tops.emplace_back(place.x(), -place.y(), has_top ? geo.altitude_m : point.z());
  }
  return tops;
}

void Add(const HardObstacle& obstacle, std::vector<Top> points, Raiser& raiser) {
  if (obstacle.shape == HardObstacle::Shape::kArea) {
    double highest_m = std::nan("");
    for (const Top& point : points) highest_m = std::fmax(highest_m, point.z());
    for (Top& point : points) point.z() = highest_m;
    raiser.AddInside(points, highest_m);
    points.push_back(points.front());
  }
  if (points.size() == 1) raiser.AddLeg(points.front(), points.front());
  for (size_t i = 1; i < points.size(); ++i) raiser.AddLeg(points[i - 1], points[i]);
}

}  // namespace

void AddObstacles(const KnownObstacles& obstacles,
                  const EmergencyRequest& request,
                  const ReachFrame& frame,
                  double path_half_width_m,
                  NearbyGround& nearby) {
  const ObstacleOptions options;
  const LocalFrame local_frame({request.place.latitude_deg, request.place.longitude_deg, 0.0});
  for (const auto& known : obstacles) {
    // The altitude of people is that of their ground.
    const double above_top_m =
        known->given.kind == ObstacleKind::kPeople ? options.people_height_m : 0.0;
    for (const HardObstacle& obstacle :
         InWorld({known}, local_frame, ReferenceOf(request), kFarM)) {
      std::vector<Top> tops = OnGrid(obstacle, local_frame, frame, nearby.ground.grid);
      for (Top& top : tops) top.z() += above_top_m;
      Raiser raiser(nearby,
                    ReachOf(obstacle, options) + path_half_width_m,
                    obstacle.height_above_ground.value_or(options.min_height_m));
      Add(obstacle, std::move(tops), raiser);
    }
  }
}

}  // namespace freelsd
