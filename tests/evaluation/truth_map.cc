#include "tests/evaluation/truth_map.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kCellM = 1.0;
// Below this the wind has no direction.
constexpr double kCalmMps = 1e-3;
// Touchdowns are tried on every n-th cell of every n-th row: closer than one can aim.
constexpr int kTouchdownStep = 3;

struct CellContent {
  float top = 0.0f;
  Cover cover = Cover::kMeadow;
};

CellContent ReadCell(const World& world, const Eigen::Vector2d& center) {
  const cv::Range rows = world.CellsAround(center.y(), 0.5 * kCellM);
  const cv::Range cols = world.CellsAround(center.x(), 0.5 * kCellM);
  CellContent content{world.surface(rows.start, cols.start), Cover::kMeadow};
  float top_of_other = -1e9f;
  for (int row = rows.start; row < rows.end; ++row) {
    for (int col = cols.start; col < cols.end; ++col) {
      const float top = world.surface(row, col);
      content.top = std::max(content.top, top);
      const Cover cover = static_cast<Cover>(world.cover(row, col));
      if (cover == Cover::kMeadow || top <= top_of_other) continue;
      top_of_other = top;
      content.cover = cover;
    }
  }
  return content;
}

Eigen::Vector2d Downwind(const World& world) {
  const double speed = world.wind_in_world.norm();
  if (speed < kCalmMps) return -Eigen::Vector2d::UnitX();
  return world.wind_in_world / speed;
}

// Every cell of a strip satisfies the claim; the world's outside does not.
template <typename Claim>
bool HoldsAlong(const TruthMap& truth,
                const Eigen::Vector2d& start,
                const Eigen::Vector2d& direction,
                double length,
                double half_width,
                Claim claim) {
  const Eigen::Vector2d across(-direction.y(), direction.x());
  const double half = 0.5 * truth.size_m;
  for (double s = 0.0; s <= length; s += truth.cell_size_m) {
    for (double t = -half_width; t <= half_width; t += truth.cell_size_m) {
      const Eigen::Vector2d place = start + s * direction + t * across;
      if (place.cwiseAbs().maxCoeff() >= half) return false;
      const cv::Point cell = truth.CellAt(place);
      if (!claim(cell)) return false;
    }
  }
  return true;
}

struct TouchdownTruth {
  bool is_free = false;
  bool is_seen = false;
};

TouchdownTruth JudgeTouchdown(const World& world,
                              const TruthMap& truth,
                              const Aircraft& aircraft,
                              const cv::Mat1b& seen,
                              const Eigen::Vector2d& place) {
  const Eigen::Vector2d downwind = Downwind(world);
  const auto is_landable = [&](const cv::Point& cell) { return truth.fault(cell) == 0; };
  const auto is_seen = [&](const cv::Point& cell) { return seen(cell) != 0; };
  TouchdownTruth answer;
  const double width = aircraft.path_half_width_m;
  answer.is_free =
      HoldsAlong(truth, place, -downwind, aircraft.ground_roll_m, width, is_landable) &&
      FinalReserve(world, aircraft, place) >= 0.0;
  if (!answer.is_free) return answer;
  const double final_length = TrueFinalLength(world, aircraft);
  answer.is_seen = HoldsAlong(truth, place, downwind, final_length, width, is_seen) &&
                   HoldsAlong(truth, place, -downwind, aircraft.ground_roll_m, width, is_seen);
  return answer;
}

void AddTouchdown(Field& field,
                  const TouchdownTruth& touchdown,
                  const Eigen::Vector2d& place,
                  double free_radius) {
  const bool is_first = touchdown.is_free && !field.is_landable;
  const bool is_of_same_kind = touchdown.is_free == field.is_landable;
  if (is_first || (is_of_same_kind && free_radius > field.free_radius)) {
    field.touchdown = place;
    field.free_radius = free_radius;
  }
  field.is_landable = field.is_landable || touchdown.is_free;
  field.num_touchdowns += touchdown.is_free;
  field.num_seen_touchdowns += touchdown.is_free && touchdown.is_seen;
}

// Ground that the touchdown disc covers wherever it fits: an opening.
cv::Mat1i LabelFields(const TruthMap& truth, const Aircraft& aircraft) {
  cv::Mat1b no_disc = truth.free_distance <= aircraft.touchdown_uncertainty_m;
  cv::Mat1f to_disc;
  cv::distanceTransform(no_disc, to_disc, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  const cv::Mat1b ground = to_disc < aircraft.touchdown_uncertainty_m / truth.cell_size_m;
  cv::Mat1i label;
  cv::connectedComponents(ground, label, 4, CV_32S);
  return label;
}

}  // namespace

Eigen::Vector2d TruthMap::CellCenter(int row, int col) const {
  return {(col + 0.5) * cell_size_m - 0.5 * size_m, (row + 0.5) * cell_size_m - 0.5 * size_m};
}

cv::Point TruthMap::CellAt(const Eigen::Vector2d& place) const {
  const auto index = [&](double coordinate) {
    const int cell = static_cast<int>(std::floor((coordinate + 0.5 * size_m) / cell_size_m));
    return std::clamp(cell, 0, fault.rows - 1);
  };
  return {index(place.x()), index(place.y())};
}

bool IsOpenGround(Cover cover) {
  return cover == Cover::kMeadow || cover == Cover::kStubble || cover == Cover::kSoil ||
         cover == Cover::kGravel || cover == Cover::kRoad;
}

TruthMap MakeTruthMap(const World& world, const Aircraft& aircraft) {
  TruthMap truth;
  truth.size_m = world.size_m;
  truth.cell_size_m = kCellM;
  const int n = static_cast<int>(std::floor(world.size_m / kCellM));
  truth.fault.create(n, n);
  truth.cover.create(n, n);
  truth.top.create(n, n);
  cv::parallel_for_({0, n}, [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      for (int col = 0; col < n; ++col) {
        const Eigen::Vector2d center = truth.CellCenter(row, col);
        const CellContent content = ReadCell(world, center);
        truth.fault(row, col) =
            static_cast<uint8_t>(GroundFaultAt(world, aircraft, center.x(), center.y(), kCellM));
        truth.cover(row, col) = static_cast<uint8_t>(content.cover);
        truth.top(row, col) = content.top;
      }
    }
  });
  const cv::Mat1b landable = truth.fault == static_cast<uint8_t>(GroundFault::kNone);
  cv::distanceTransform(landable, truth.free_distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  truth.free_distance *= kCellM;
  return truth;
}

Fields FindFields(const World& world,
                  const TruthMap& truth,
                  const Aircraft& aircraft,
                  const cv::Mat1b& seen) {
  Fields answer;
  const cv::Mat1i component = LabelFields(truth, aircraft);
  double num_components = 0.0;
  cv::minMaxLoc(component, nullptr, &num_components);
  std::vector<Field> all(static_cast<size_t>(num_components) + 1);
  for (int row = 0; row < component.rows; ++row) {
    for (int col = 0; col < component.cols; ++col) {
      if (component(row, col) == 0) continue;
      Field& field = all[static_cast<size_t>(component(row, col))];
      field.area_m2 += kCellM * kCellM;
      if (row % kTouchdownStep != 0 || col % kTouchdownStep != 0) continue;
      const float radius = truth.free_distance(row, col);
      if (radius <= aircraft.touchdown_uncertainty_m) continue;
      const Eigen::Vector2d place = truth.CellCenter(row, col);
      AddTouchdown(field, JudgeTouchdown(world, truth, aircraft, seen, place), place, radius);
    }
  }
  std::vector<int> index(all.size(), 0);
  for (size_t i = 1; i < all.size(); ++i) {
    if (all[i].area_m2 < aircraft.min_area_m2) continue;
    all[i].id = static_cast<int>(answer.fields.size()) + 1;
    all[i].has_loiter = std::max(LoiterReserve(world, aircraft, all[i].touchdown, 1),
                                 LoiterReserve(world, aircraft, all[i].touchdown, -1)) >= 0.0;
    index[i] = all[i].id;
    answer.fields.push_back(all[i]);
  }
  answer.label.create(component.size());
  std::transform(component.begin(), component.end(), answer.label.begin(), [&](int i) {
    return index[static_cast<size_t>(i)];
  });
  return answer;
}

}  // namespace freelsd
