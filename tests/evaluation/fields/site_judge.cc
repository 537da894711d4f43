#include "tests/evaluation/fields/site_judge.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace freelsd {
namespace {

// Cells at the border of an outline decide nothing.
constexpr double kMinLandRatio = 0.99;

enum class Part { kDisc, kRoll, kFinal };

struct Conflict {
  Part part = Part::kDisc;
  const LabelledObject* object = nullptr;
};

// The path over ground, and how far a place is from it.
class Path {
 public:
  Path(const LabelledGround& ground, const Aircraft& aircraft, const Approach& approach)
      : ground_(ground),
        aircraft_(aircraft),
        touchdown_(approach.touchdown_in_world.head<2>()),
        forward_(DirectionOf(approach.heading)),
        length_((approach.approach_start_in_world - approach.touchdown_in_world).head<2>().norm()),
        start_height_(approach.approach_start_in_world.z() - approach.touchdown_in_world.z()),
        touchdown_height_(ground.bare_heights.At(touchdown_)) {}

  bool IsInDisc(const Eigen::Vector2d& place, double narrowing) const {
    return (place - touchdown_).norm() <= aircraft_.touchdown_uncertainty_m - narrowing;
  }
  bool IsOnRoll(const Eigen::Vector2d& place, double narrowing) const {
    const double along = Along(place);
    return along >= 0.0 && along <= aircraft_.ground_roll_m - narrowing &&
           Across(place) <= aircraft_.path_half_width_m - narrowing;
  }
  // A thing of this height at a place in the corridor reaches up to the final.
  bool BlocksFinal(const Eigen::Vector2d& place, double height_m) const {
    const double tolerance = ground_.tolerance_m;
    const double from_touchdown = -Along(place);
    if (from_touchdown < aircraft_.touchdown_uncertainty_m || from_touchdown > length_)
      return false;
    if (Across(place) > std::max(0.0, aircraft_.path_half_width_m - tolerance)) return false;
    const double share = std::min(1.0, (from_touchdown + tolerance) / std::max(length_, 1e-9));
    return touchdown_height_ + share * start_height_ < ground_.bare_heights.At(place) + height_m;
  }
  double CircleHeight() const { return touchdown_height_ + start_height_; }
  // Longest distance from touchdown to anything on disc, roll and final.
  double Reach() const {
    return std::max({aircraft_.touchdown_uncertainty_m, aircraft_.ground_roll_m, length_}) +
           aircraft_.path_half_width_m;
  }
  double GroundReach() const {
    return std::max(aircraft_.touchdown_uncertainty_m, aircraft_.ground_roll_m) +
           aircraft_.path_half_width_m;
  }
  const Eigen::Vector2d& touchdown() const { return touchdown_; }

 private:
  double Along(const Eigen::Vector2d& place) const { return (place - touchdown_).dot(forward_); }
  double Across(const Eigen::Vector2d& place) const {
    return std::abs((place - touchdown_).dot(Eigen::Vector2d(forward_.y(), -forward_.x())));
  }

  const LabelledGround& ground_;
  const Aircraft& aircraft_;
  Eigen::Vector2d touchdown_;
  Eigen::Vector2d forward_;
  double length_;
  double start_height_;
  double touchdown_height_;
};

// Calls `visit` for the places of an object within a distance of a centre until it returns true.
bool AnyPlace(const LabelledGround& ground,
              const LabelledObject& object,
              const Eigen::Vector2d& center,
              double reach,
              const std::function<bool(const Eigen::Vector2d&)>& visit) {
  const cv::Rect cells = object.cells & ground.grid.CellsAround({center}, reach);
  for (int row = cells.y; row < cells.y + cells.height; ++row) {
    for (int col = cells.x; col < cells.x + cells.width; ++col) {
      if (object.mask(row - object.cells.y, col - object.cells.x) == 0) continue;
      if (visit(ground.grid.CellCenter(row, col))) return true;
    }
  }
  return false;
}

// Disc first, then roll, then final; by id.
std::optional<Conflict> FirstConflict(const LabelledGround& ground,
                                      const Path& path,
                                      bool with_thin) {
  const double tolerance = ground.tolerance_m;
  const auto meets = [&](const LabelledObject& object, Part part) {
    if (part == Part::kFinal && object.height_m <= 0.0) return false;
    return AnyPlace(
        ground, object, path.touchdown(), path.Reach(), [&](const Eigen::Vector2d& place) {
          if (part == Part::kDisc) return path.IsInDisc(place, tolerance);
          if (part == Part::kRoll) return path.IsOnRoll(place, tolerance);
          return path.BlocksFinal(place, object.height_m);
        });
  };
  for (const Part part : {Part::kDisc, Part::kRoll, Part::kFinal}) {
    for (const LabelledObject& object : ground.objects) {
      if (!object.IsDanger() || (!with_thin && IsThin(object.kind))) continue;
      if (meets(object, part)) return Conflict{part, &object};
    }
  }
  return std::nullopt;
}

bool IsInDoubt(const LabelledGround& ground, const cv::Point& cell) {
  return std::any_of(
      ground.objects.begin(), ground.objects.end(), [&](const LabelledObject& object) {
        return object.kind == OutlineKind::kDoubt && object.cells.contains(cell) &&
               object.mask(cell - object.cells.tl()) != 0;
      });
}

// Shares of the cells under disc and roll that are land, or within the tolerance of it, and in
// doubt.
void FillRatios(const LabelledGround& ground, const Path& path, SiteJudgement* judgement) {
  const double step = ground.grid.cell_size_m, reach = path.GroundReach();
  int num_cells = 0, num_land = 0, num_doubt = 0;
  for (double east = -reach; east <= reach; east += step) {
    for (double north = -reach; north <= reach; north += step) {
      const Eigen::Vector2d place = path.touchdown() + Eigen::Vector2d(east, north);
      if (!path.IsInDisc(place, 0.0) && !path.IsOnRoll(place, 0.0)) continue;
      ++num_cells;
      const auto cell = ground.grid.CellAt(place);
      if (!cell) continue;
      num_land += ground.distance_to_land(*cell) <= ground.tolerance_m;
      num_doubt += IsInDoubt(ground, *cell);
    }
  }
  if (num_cells == 0) return;
  judgement->land_ratio = double(num_land) / num_cells;
  judgement->doubt_ratio = double(num_doubt) / num_cells;
}

std::string CircleConflict(const LabelledGround& ground,
                           const Aircraft& aircraft,
                           const Approach& approach,
                           double height) {
  const Eigen::Vector2d center = approach.loiter_center_in_world.head<2>();
  const double half_width = std::max(0.0, aircraft.path_half_width_m - ground.tolerance_m);
  const double reach = approach.loiter_radius + half_width;
  for (const LabelledObject& object : ground.objects) {
    if (!object.IsDanger() || object.height_m <= 0.0) continue;
    if (AnyPlace(ground, object, center, reach, [&](const Eigen::Vector2d& place) {
          const double off = std::abs((place - center).norm() - approach.loiter_radius);
          return off <= half_width && ground.bare_heights.At(place) + object.height_m > height;
        })) {
      return NameOf(object.kind);
    }
  }
  return "";
}

}  // namespace

const char* NameOf(Finding finding) {
  switch (finding) {
    case Finding::kRight:
      return "right";
    case Finding::kNotJudged:
      return "not judged";
    case Finding::kFalseSafe:
      break;
  }
  return "false safe";
}

SiteJudgement JudgeApproach(const LabelledGround& ground,
                            const Aircraft& aircraft,
                            const Approach& approach) {
  const Path path(ground, aircraft, approach);
  SiteJudgement judgement;
  if (ground.grid.num_rows > 0) FillRatios(ground, path, &judgement);
  judgement.circle = CircleConflict(ground, aircraft, approach, path.CircleHeight());
  const std::optional<Conflict> solid = FirstConflict(ground, path, false);
  const std::optional<Conflict> conflict = solid ? solid : FirstConflict(ground, path, true);
  if (!conflict) {
    judgement.finding =
        judgement.land_ratio >= kMinLandRatio ? Finding::kRight : Finding::kNotJudged;
    return judgement;
  }
  constexpr const char* kParts[] = {"disc: ", "roll: ", "final: "};
  judgement.finding = Finding::kFalseSafe;
  judgement.cause =
      std::string(kParts[static_cast<size_t>(conflict->part)]) + NameOf(conflict->object->kind);
  judgement.object_id = conflict->object->id;
  judgement.is_only_thin = !solid.has_value();
  return judgement;
}

}  // namespace freelsd
