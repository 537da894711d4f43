#include "engine/next_look/landing_squares.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace freelsd {
namespace {

// Landings with a smaller probability are not worth a look.
constexpr double kLeastProbability = 0.02;
// Share of the cells of a path that leaves no doubt of it.
constexpr double kWhollyKnown = 0.99;
// Final headings that are tried where the wind does not choose one.
constexpr int kNumHeadings = 4;
constexpr double kCalmWindMps = 0.5;
// The planner found no obstacle below the seen part of an unverified site's circle, whatever the
// coarse cells say.
constexpr double kLeastOfCircle = 0.5;

// Gathers the cells of one part of a landing, and asks the worst of them.
class Part {
 public:
  explicit Part(const KnownGround& ground) : ground_(ground) {}

  // A place to roll over: at least so far from what is surely no landing ground.
  void AddGround(const Eigen::Vector2d& place, double least_clear_m) {
    const auto cell = Take(place);
    if (!cell) return;
    const bool is_clear = ground_.clear_distance(*cell) >= least_clear_m;
    Ask(*cell,
        is_clear ? ground_.free(*cell) : 0.0f,
        is_clear ? ground_.fit_prospect(*cell) : 0.0f);
  }
  // A place that a path crosses at this height, world z, above obstacles or above everything.
  void AddPath(const Eigen::Vector2d& place, const cv::Mat1f& tops, double path_height) {
    const auto cell = Take(place);
    if (!cell) return;
    const bool is_clear = !(tops(*cell) > path_height);
    Ask(*cell,
        is_clear ? ground_.known(*cell) : 0.0f,
        is_clear ? ground_.low_prospect(*cell) : 0.0f);
  }
  NeededCells Needed() {
    std::sort(needed_.cells.begin(), needed_.cells.end());
    const auto end = std::unique(needed_.cells.begin(), needed_.cells.end());
    needed_.num_cells -= static_cast<int>(needed_.cells.end() - end);
    needed_.cells.erase(end, needed_.cells.end());
    return std::move(needed_);
  }
  double probability() const { return probability_; }

 private:
  std::optional<cv::Point> Take(const Eigen::Vector2d& place) {
    ++needed_.num_cells;
    const auto cell = ground_.grid.CellAt(place);
    if (cell) needed_.cells.push_back(cell->y * ground_.grid.num_cols + cell->x);
    return cell;
  }
  // Known to pass, and what is expected of the unknown share of the cell.
  void Ask(const cv::Point& cell, float passes, float prospect) {
    const double probability = passes + (1.0 - ground_.known(cell)) * prospect;
    probability_ = std::min(probability_, probability);
  }

  const KnownGround& ground_;
  NeededCells needed_;
  double probability_ = 1.0;
};

struct PathShape {
  double heading = 0.0;
  double approach_distance = 0.0;
  double approach_height = 0.0;
  double loiter_radius = 0.0;
};

// Touchdown disc and ground roll.
void AddGround(const Eigen::Vector2d& touchdown,
               const PathShape& shape,
               const Aircraft& aircraft,
               const KnownGround& ground,
               Part& part) {
  const double step = ground.grid.cell_size_m, radius = aircraft.touchdown_uncertainty_m;
  part.AddGround(touchdown, ground.disc_radius_m);
  for (double east = -radius; east <= radius; east += step) {
    for (double north = -radius; north <= radius; north += step) {
      if (std::hypot(east, north) > radius) continue;
      part.AddGround(touchdown + Eigen::Vector2d(east, north), 0.0);
    }
  }
  for (double along = step; along <= aircraft.ground_roll_m + radius; along += step) {
    part.AddGround(touchdown + along * DirectionOf(shape.heading), aircraft.path_half_width_m);
  }
}

void AddFinal(const Eigen::Vector3d& touchdown,
              const PathShape& shape,
              const Aircraft& aircraft,
              const KnownGround& ground,
              Part& part) {
  const double step = ground.grid.cell_size_m, half_width = ground.corridor_half_width_m;
  const Eigen::Vector2d back = -DirectionOf(shape.heading), right(-back.y(), back.x());
  const double slope = shape.approach_height / shape.approach_distance;
  for (double before = aircraft.touchdown_uncertainty_m; before < shape.approach_distance;
       before += step) {
    const double height =
        std::max(before * slope - aircraft.safety_margin_m, aircraft.max_roughness_m);
    for (double aside = -half_width; aside <= half_width; aside += step) {
      part.AddPath(touchdown.head<2>() + before * back + aside * right,
                   ground.obstacle_top,
                   touchdown.z() + height);
    }
  }
}

void AddCircle(const Eigen::Vector2d& center,
               double height,
               double radius,
               const Aircraft& aircraft,
               const KnownGround& ground,
               Part& part) {
  const double step = ground.grid.cell_size_m, half_width = ground.corridor_half_width_m;
  const int num_steps = std::max(8, static_cast<int>(std::ceil(2.0 * kPi * radius / step)));
  for (int i = 0; i < num_steps; ++i) {
    const Eigen::Vector2d out = DirectionOf(2.0 * kPi * i / num_steps);
    for (double aside = -half_width; aside <= half_width; aside += step) {
      part.AddPath(center + (radius + aside) * out, ground.top, height - aircraft.safety_margin_m);
    }
  }
}

// Headings of the final, and its measures, in the request's wind.
std::vector<PathShape> PathShapes(const LookRequest& request) {
  const Aircraft& aircraft = request.aircraft;
  const Eigen::Vector2d wind = request.wind_in_world.value_or(Eigen::Vector2d::Zero());
  const double speed = wind.norm();
  PathShape shape;
  shape.approach_height = aircraft.approach_height_m;
  shape.approach_distance = ApproachDistance(aircraft, speed);
  shape.loiter_radius = LoiterRadius(aircraft, speed);
  if (!(shape.approach_distance > 0.0)) return {};
  if (speed >= kCalmWindMps) {
    shape.heading = HeadingOf(-wind);
    return {shape};
  }
  std::vector<PathShape> shapes(kNumHeadings, shape);
  for (int i = 0; i < kNumHeadings; ++i) {
    shapes[static_cast<size_t>(i)].heading = 2.0 * kPi * i / kNumHeadings;
  }
  return shapes;
}

// Into both sides of the final; those that may succeed.
void TryLandings(const Eigen::Vector2d& place,
                 const std::vector<PathShape>& shapes,
                 const Aircraft& aircraft,
                 const KnownGround& ground,
                 std::vector<TriedLanding>& landings) {
  const auto cell = ground.grid.CellAt(place);
  if (!cell || ground.clear_distance(*cell) < ground.disc_radius_m) return;
  const Eigen::Vector3d touchdown(place.x(), place.y(), ground.height(*cell));
  for (const PathShape& shape : shapes) {
    Part path(ground);
    AddGround(place, shape, aircraft, ground, path);
    AddFinal(touchdown, shape, aircraft, ground, path);
    if (path.probability() < kLeastProbability) continue;
    const NeededCells path_cells = path.Needed();
    // The planner has judged what is wholly known, and accepted nothing better than the sites.
    if (path_cells.KnownShare(ground.known) >= kWhollyKnown) continue;
    const Eigen::Vector2d ahead = DirectionOf(shape.heading), right(ahead.y(), -ahead.x());
    for (const double side : {-1.0, 1.0}) {
      Part circle(ground);
      const Eigen::Vector2d center =
          place - shape.approach_distance * ahead + side * shape.loiter_radius * right;
      AddCircle(center,
                touchdown.z() + shape.approach_height,
                shape.loiter_radius,
                aircraft,
                ground,
                circle);
      const double probability = path.probability() * circle.probability();
      if (probability < kLeastProbability) continue;
      landings.push_back({touchdown, probability, path_cells, circle.Needed()});
    }
  }
}

TriedLanding LandingOf(const SiteSoFar& site, const Aircraft& aircraft, const KnownGround& ground) {
  const PlannedLanding& landing = *site.landing;
  Part circle(ground);
  AddCircle(landing.loiter_center_in_world,
            site.touchdown_in_world.z() + landing.approach_height,
            landing.loiter_radius,
            aircraft,
            ground,
            circle);
  const double probability = std::max(circle.probability(), kLeastOfCircle);
  return {site.touchdown_in_world, probability, {}, circle.Needed()};
}

double ValueOf(Verdict verdict, const NextLookOptions& options) {
  if (verdict == Verdict::kLandable) return 1.0;
  return verdict == Verdict::kUnverified ? options.unverified_value : 0.0;
}

using SquareKey = std::pair<int, int>;

SquareKey KeyOf(const Eigen::Vector2d& place, double side_m) {
  return {static_cast<int>(std::floor(place.x() / side_m)),
          static_cast<int>(std::floor(place.y() / side_m))};
}

// The best site of each square that has one. Verdicts are ordered best first.
std::map<SquareKey, size_t> BestSites(const std::vector<SiteSoFar>& sites, double side_m) {
  std::map<SquareKey, size_t> best;
  for (size_t i = 0; i < sites.size(); ++i) {
    const auto [entry, is_new] =
        best.try_emplace(KeyOf(sites[i].touchdown_in_world.head<2>(), side_m), i);
    if (!is_new && sites[i].verdict < sites[entry->second].verdict) entry->second = i;
  }
  return best;
}

void AddTouchdowns(const SquareKey& key,
                   const LookRequest& request,
                   const KnownGround& ground,
                   const NextLookOptions& options,
                   std::vector<TriedLanding>& landings) {
  const std::vector<PathShape> shapes = PathShapes(request);
  const int num_steps = std::max(
      1, static_cast<int>(std::lround(options.place_extent_m / options.touchdown_spacing_m)));
  const Eigen::Vector2d corner = options.place_extent_m * Eigen::Vector2d(key.first, key.second);
  for (int i = 0; i < num_steps * num_steps; ++i) {
    const int row = i / num_steps;
    const Eigen::Vector2d step(i % num_steps + 0.5, row + 0.5);
    TryLandings(corner + options.place_extent_m / num_steps * step,
                shapes,
                request.aircraft,
                ground,
                landings);
  }
}

// Around the cells of all landings.
cv::Rect CellsOf(const LandingSquare& square, int num_cols) {
  cv::Point least(num_cols, std::numeric_limits<int>::max()), most(-1, -1);
  for (const TriedLanding& landing : square.landings) {
    for (const NeededCells* const part : {&landing.path, &landing.circle}) {
      for (const int index : part->cells) {
        const cv::Point cell(index % num_cols, index / num_cols);
        least = {std::min(least.x, cell.x), std::min(least.y, cell.y)};
        most = {std::max(most.x, cell.x), std::max(most.y, cell.y)};
      }
    }
  }
  return most.x < 0 ? cv::Rect() : cv::Rect(least, most + cv::Point(1, 1));
}

}  // namespace

double NeededCells::KnownShare(const cv::Mat1f& known) const {
  if (num_cells == 0) return 1.0;
  double sum = 0.0;
  const float* const values = known.ptr<float>();
  for (const int cell : cells) sum += values[cell];
  return sum / num_cells;
}

double TriedLanding::ValueAt(const cv::Mat1f& known, const NextLookOptions& options) const {
  const double path_known = std::pow(path.KnownShare(known), options.missing_exponent);
  const double circle_known = std::pow(circle.KnownShare(known), options.missing_exponent);
  return probability * path_known *
         (options.unverified_value + (1.0 - options.unverified_value) * circle_known);
}

double LandingSquare::ValueAt(const cv::Mat1f& known, const NextLookOptions& options) const {
  double value = 0.0;
  for (const TriedLanding& landing : landings) {
    if (landing.probability <= value) break;
    value = std::max(value, landing.ValueAt(known, options));
  }
  return value;
}

const TriedLanding& LandingSquare::BestAt(const cv::Mat1f& known,
                                          const NextLookOptions& options) const {
  return *std::max_element(
      landings.begin(), landings.end(), [&](const TriedLanding& a, const TriedLanding& b) {
        return a.ValueAt(known, options) < b.ValueAt(known, options);
      });
}

LandingSquares FindSquares(const LookRequest& request,
                           const KnownGround& ground,
                           const NextLookOptions& options) {
  const double side_m = options.place_extent_m;
  const std::map<SquareKey, size_t> sites = BestSites(request.sites, side_m);
  const Grid& grid = ground.grid;
  const SquareKey first = KeyOf(grid.CellCenter(grid.num_rows - 1, 0), side_m);
  const SquareKey last = KeyOf(grid.CellCenter(0, grid.num_cols - 1), side_m);
  LandingSquares squares;
  for (SquareKey key = first; key.second <= last.second; ++key.second) {
    for (key.first = first.first; key.first <= last.first; ++key.first) {
      LandingSquare square;
      if (const auto site = sites.find(key); site != sites.end()) {
        const SiteSoFar& best = request.sites[site->second];
        squares.landing_value += ValueOf(best.verdict, options);
        if (best.verdict == Verdict::kLandable) continue;
        square.site = site->second;
        if (best.verdict == Verdict::kUnverified && best.landing) {
          square.landings.push_back(LandingOf(best, request.aircraft, ground));
        }
      }
      AddTouchdowns(key, request, ground, options, square.landings);
      if (square.landings.empty()) continue;
      std::stable_sort(square.landings.begin(),
                       square.landings.end(),
                       [](const TriedLanding& a, const TriedLanding& b) {
                         return a.probability > b.probability;
                       });
      square.cells = CellsOf(square, grid.num_cols);
      squares.open.push_back(std::move(square));
    }
  }
  return squares;
}

}  // namespace freelsd
