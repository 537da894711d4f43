#include "engine/next_look/next_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "engine/check/check.h"
#include "engine/glide/glide.h"
#include "engine/next_look/landing_squares.h"
#include "engine/next_look/leg_choice.h"

namespace freelsd {
namespace {

// Photographs overlap along the leg at least by the rest of the largest share, and need not follow
// faster than the smallest one.
constexpr double kMinSpacingRatio = 0.1;
constexpr double kMaxSpacingRatio = 0.4;

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void CheckRequest(const LookRequest& request) {
  if (!(request.map.grid == request.layers.grid)) {
    throw std::invalid_argument("next_look.grid: layers and map are not of the same grid");
  }
  if (request.num_views.size() != request.map.elevation.size()) {
    throw std::invalid_argument("next_look.num_views: not of the map's grid");
  }
  if (request.flown.empty()) {
    throw std::invalid_argument("next_look.flown: must have at least one photograph");
  }
  if (cv::countNonZero(request.layers.hazard != kUnseen) == 0) {
    throw std::invalid_argument("next_look.map: must have at least one seen cell");
  }
}

// Median over the photographs that see their own ground, else over the whole map.
double HeightAboveGround(const LookRequest& request) {
  std::vector<double> grounds, heights, altitudes;
  for (int row = 0; row < request.map.elevation.rows; ++row) {
    for (int col = 0; col < request.map.elevation.cols; ++col) {
      if (request.layers.hazard(row, col) != kUnseen) {
        grounds.push_back(request.map.elevation(row, col));
      }
    }
  }
  for (const Rigid3d& pose : request.flown) {
    altitudes.push_back(pose.translation.z());
    const auto cell = request.map.grid.CellAt(pose.translation.head<2>());
    if (!cell || request.layers.hazard(*cell) == kUnseen) continue;
    heights.push_back(pose.translation.z() - request.map.elevation(*cell));
  }
  const double height =
      heights.empty() ? MedianOf(altitudes) - MedianOf(grounds) : MedianOf(heights);
  return std::max(height, 1.0);
}

double PhotoSpacing(const std::vector<Rigid3d>& flown, double extent_m) {
  std::vector<double> spacings;
  for (size_t i = 1; i < flown.size(); ++i) {
    spacings.push_back((flown[i].translation - flown[i - 1].translation).norm());
  }
  const double flown_m = spacings.empty() ? kMaxSpacingRatio * extent_m : MedianOf(spacings);
  return std::clamp(flown_m, kMinSpacingRatio * extent_m, kMaxSpacingRatio * extent_m);
}

Box MapBox(const Grid& grid) {
  Box box;
  const Eigen::Vector2d extent = grid.cell_size_m * Eigen::Vector2d(grid.num_cols, -grid.num_rows);
  box.Add(grid.north_west_in_world);
  box.Add(grid.north_west_in_world + extent);
  return box;
}

// Of the flight so far: the place and direction from which the aircraft comes.
Stance LastStance(const std::vector<Rigid3d>& flown) {
  const Eigen::Vector3d last = flown.back().translation;
  for (size_t i = flown.size() - 1; i-- > 0;) {
    const Eigen::Vector3d way = last - flown[i].translation;
    if (way.head<2>().norm() >= 1.0) return {last.head<2>(), HeadingOf(way.head<2>())};
  }
  return {last.head<2>(), 0.0};
}

double TransitLength(const Stance& from, const Stance& to, double radius_m) {
  const TurnPath path = ShortestTurns(from, to, radius_m);
  return path.straight_m + radius_m * path.Turned();
}

LegLine Reversed(const LegLine& leg) { return {leg.To(), leg.heading + kPi, leg.length_m}; }

// The nearest leg next, in the direction that is nearer.
std::vector<LookLeg> InOrderOfFlight(std::vector<std::pair<LookLeg, LegLine>> legs,
                                     Stance stance,
                                     double radius_m) {
  std::vector<LookLeg> ordered;
  while (!legs.empty()) {
    size_t next = 0;
    LegLine next_line;
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < legs.size(); ++i) {
      for (const LegLine& line : {legs[i].second, Reversed(legs[i].second)}) {
        const double length = TransitLength(stance, {line.from_in_world, line.heading}, radius_m);
        if (length >= least) continue;
        least = length;
        next = i;
        next_line = line;
      }
    }
    LookLeg leg = std::move(legs[next].first);
    legs.erase(legs.begin() + static_cast<std::ptrdiff_t>(next));
    leg.from_in_world.head<2>() = next_line.from_in_world;
    leg.to_in_world.head<2>() = next_line.To();
    leg.heading = HeadingOf((leg.to_in_world - leg.from_in_world).head<2>());
    leg.transit_m = least;
    stance = {next_line.To(), leg.heading};
    ordered.push_back(std::move(leg));
  }
  return ordered;
}

// World z of a leg: as high above its ground as the flight so far, but clear of all that is seen.
double AltitudeOf(const LegLine& leg,
                  const KnownGround& ground,
                  double height_above_ground,
                  const NextLookOptions& options) {
  constexpr double kNearM = 50.0;
  const Eigen::Vector2d ahead = DirectionOf(leg.heading), right(ahead.y(), -ahead.x());
  double sum = 0.0, highest = -std::numeric_limits<double>::infinity();
  int num_cells = 0;
  for (double along = -kNearM; along <= leg.length_m + kNearM; along += ground.grid.cell_size_m) {
    for (double aside = -kNearM; aside <= kNearM; aside += ground.grid.cell_size_m) {
      const auto cell = ground.grid.CellAt(leg.from_in_world + along * ahead + aside * right);
      if (!cell) continue;
      sum += ground.height(*cell);
      highest = std::max(highest, static_cast<double>(ground.top(*cell)));
      ++num_cells;
    }
  }
  const double mean = num_cells > 0 ? sum / num_cells : 0.0;
  return std::max(mean + height_above_ground, highest + options.min_clearance_m);
}

std::vector<LookedPlace> PlacesOf(const std::vector<LandingSquare>& squares,
                                  const cv::Mat1f& before,
                                  const cv::Mat1f& after,
                                  const NextLookOptions& options) {
  std::vector<LookedPlace> places;
  for (const LandingSquare& square : squares) {
    const double gain = square.ValueAt(after, options) - square.ValueAt(before, options);
    if (gain < options.min_told_gain) continue;
    places.push_back({square.BestAt(after, options).touchdown_in_world, square.site, gain});
  }
  std::stable_sort(places.begin(), places.end(), [](const LookedPlace& a, const LookedPlace& b) {
    return a.expected_gain > b.expected_gain;
  });
  return places;
}

}  // namespace

void NextLookOptions::Check() const {
  const FieldCheck check("next_look");
  check.Inside("num_legs", num_legs, 1.0, 8.0);
  check.Inside("leg_length_m", leg_length_m, 20.0, 10000.0);
  check.Inside("num_leg_directions", num_leg_directions, 1.0, 180.0);
  check.Inside("max_outside_m", max_outside_m, 0.0, 10000.0);
  check.Inside("min_shared_ratio", min_shared_ratio, 0.0, 1.0);
  check.Inside("num_views_to_know", num_views_to_know, 1.0, 100.0);
  check.Inside("min_doubtful_posterior", min_doubtful_posterior, 0.0, 1.0);
  check.Inside("prospect_length_m", prospect_length_m, 1.0, 10000.0);
  check.Inside("missing_exponent", missing_exponent, 1.0, 100.0);
  check.Inside("place_extent_m", place_extent_m, 5.0, 1000.0);
  check.Inside("touchdown_spacing_m", touchdown_spacing_m, 1.0, 1000.0);
  check.Inside("unverified_value", unverified_value, 0.0, 1.0);
  check.Inside("cell_size_m", cell_size_m, 0.5, 100.0);
  check.Inside("num_shortlisted_legs", num_shortlisted_legs, 1.0, 100000.0);
  check.Inside("min_told_gain", min_told_gain, 0.0, 1.0);
  check.Inside("min_clearance_m", min_clearance_m, 0.0, 1000.0);
}

NextLook ChooseNextLook(const LookRequest& request, const NextLookOptions& options) {
  options.Check();
  CheckRequest(request);
  NextLook look;
  look.height_above_ground_m = HeightAboveGround(request);
  LookFlight flight{PhotoShape(request.rig, look.height_above_ground_m), 0.0, request.before_leg};
  look.photo_extent_m = flight.shape.Extent();
  look.photo_spacing_m = PhotoSpacing(request.flown, look.photo_extent_m.x());
  flight.photo_spacing_m = look.photo_spacing_m;
  const double wind_speed = request.wind_in_world ? request.wind_in_world->norm() : 0.0;
  look.turn_radius_m = LoiterRadius(request.aircraft, wind_speed);
  Box area = MapBox(request.map.grid);
  area.Grow(options.max_outside_m);
  if (request.area) area = *request.area;
  Box shown = area;
  shown.Grow(0.5 * look.photo_extent_m.norm());
  KnownGround ground = MeasureKnownGround(request, shown, options);
  const LandingSquares squares = FindSquares(request, ground, options);
  look.landing_value = squares.landing_value;
  const std::vector<LegLine> legs = LegsIn(area, flight, options);
  std::vector<std::pair<LookLeg, LegLine>> chosen;
  for (int i = 0; i < options.num_legs; ++i) {
    auto best = BestLeg(legs, squares.open, ground, flight, options);
    if (!best) break;
    LookLeg leg;
    leg.expected_gain = best->expected_gain;
    leg.places = PlacesOf(squares.open, ground.known, best->known, options);
    leg.from_in_world.z() = leg.to_in_world.z() =
        AltitudeOf(best->line, ground, look.height_above_ground_m, options);
    look.expected_gain += leg.expected_gain;
    ground.known = best->known;
    const LegViews views = ViewsOf(best->line, flight.shape, flight.photo_spacing_m, ground.grid);
    cv::Mat1f(ground.num_shown(views.cells)) += views.num_views;
    chosen.emplace_back(std::move(leg), best->line);
  }
  look.legs = InOrderOfFlight(std::move(chosen), LastStance(request.flown), look.turn_radius_m);
  return look;
}

}  // namespace freelsd
