#include "engine/next_look/leg_choice.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace freelsd {
namespace {

// Neighbouring legs share most of their photographs.
constexpr double kLatticeSteps = 5.0;

// Chance that new photographs make a cell known, of which earlier ones left something unknown. What
// enough of them did not tell is hard to see: trees, water, moving things.
double ChanceToKnow(double num_new, double num_shown, double num_needed) {
  const double num_missing = num_needed - num_shown;
  if (num_missing > 0.0) return std::min(1.0, num_new / num_missing);
  return std::min(1.0, num_new / num_needed) / (2.0 - num_missing);
}

cv::Mat1f ChancesOf(const LegViews& views,
                    const KnownGround& ground,
                    const NextLookOptions& options) {
  cv::Mat1f chances(views.num_views.size());
  for (int row = 0; row < chances.rows; ++row) {
    for (int col = 0; col < chances.cols; ++col) {
      const float num_shown = ground.num_shown(views.cells.y + row, views.cells.x + col);
      chances(row, col) = static_cast<float>(
          ChanceToKnow(views.num_views(row, col), num_shown, options.num_views_to_know));
    }
  }
  return chances;
}

cv::Mat1f KnownAfter(const LegViews& views,
                     const KnownGround& ground,
                     const NextLookOptions& options) {
  cv::Mat1f after = ground.known.clone();
  cv::Mat1f part = after(views.cells);
  cv::Mat1f(part + ChancesOf(views, ground, options).mul(1.0f - part)).copyTo(part);
  return after;
}

// What each unknown cell may add, if the best landing of a square that needs it lacked only cells
// like it.
cv::Mat1f ClaimsOf(const std::vector<LandingSquare>& squares,
                   const KnownGround& ground,
                   const NextLookOptions& options) {
  cv::Mat1f claims(ground.known.size(), 0.0f);
  float* const values = claims.ptr<float>();
  const float* const known = ground.known.ptr<float>();
  for (const LandingSquare& square : squares) {
    const auto best = std::max_element(
        square.landings.begin(), square.landings.end(), [](const auto& a, const auto& b) {
          return a.probability < b.probability;
        });
    const double lacking = best->probability - best->ValueAt(ground.known, options);
    double num_unknown = 0.0;
    for (const NeededCells* const part : {&best->path, &best->circle}) {
      for (const int cell : part->cells) num_unknown += 1.0f - known[cell];
    }
    if (num_unknown < 1.0 || lacking <= 0.0) continue;
    const auto share = static_cast<float>(lacking / num_unknown);
    for (const NeededCells* const part : {&best->path, &best->circle}) {
      for (const int cell : part->cells) values[cell] += share * (1.0f - known[cell]);
    }
  }
  return claims;
}

// Of the ground that a leg shows, the share that photographs have shown already.
double SharedRatio(const LegViews& views, const KnownGround& ground) {
  const cv::Mat1b is_shown = views.num_views > 0.0f;
  const cv::Mat1b is_shared = is_shown & (ground.num_shown(views.cells) > 0.0f);
  const int num_shown = cv::countNonZero(is_shown);
  return num_shown == 0 ? 0.0 : static_cast<double>(cv::countNonZero(is_shared)) / num_shown;
}

// Largest claims first.
std::vector<LegLine> Shortlist(const std::vector<LegLine>& legs,
                               const cv::Mat1f& claims,
                               const KnownGround& ground,
                               const LookFlight& flight,
                               const NextLookOptions& options) {
  std::vector<std::pair<double, size_t>> ranked;
  for (size_t i = 0; i < legs.size(); ++i) {
    flight.before_leg();
    const LegViews views = ViewsOf(legs[i], flight.shape, flight.photo_spacing_m, ground.grid);
    if (SharedRatio(views, ground) < options.min_shared_ratio) continue;
    ranked.emplace_back(-claims(views.cells).dot(ChancesOf(views, ground, options)), i);
  }
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(std::min(ranked.size(), static_cast<size_t>(options.num_shortlisted_legs)));
  std::vector<LegLine> shortlist;
  shortlist.reserve(ranked.size());
  for (const auto& [claim, index] : ranked) shortlist.push_back(legs[index]);
  return shortlist;
}

}  // namespace

std::vector<LegLine> LegsIn(const Box& area,
                            const LookFlight& flight,
                            const NextLookOptions& options) {
  const double step = std::max(flight.shape.Extent().y() / kLatticeSteps, options.cell_size_m);
  const Eigen::Vector2d extent = area.max - area.min;
  const int num_cols = static_cast<int>(extent.x() / step) + 1;
  const int num_rows = static_cast<int>(extent.y() / step) + 1;
  // The lattice lies in the middle of the area.
  const Eigen::Vector2d first =
      0.5 * (area.min + area.max) - 0.5 * step * Eigen::Vector2d(num_cols - 1, num_rows - 1);
  std::vector<LegLine> legs;
  for (int i = 0; i < num_rows * num_cols * options.num_leg_directions; ++i) {
    const int place = i / options.num_leg_directions;
    const double heading = kPi * (i % options.num_leg_directions) / options.num_leg_directions;
    const Eigen::Vector2d middle =
        first + step * Eigen::Vector2d(place % num_cols, place / num_cols);
    const LegLine leg{
        middle - 0.5 * options.leg_length_m * DirectionOf(heading), heading, options.leg_length_m};
    if (area.DistanceTo(leg.from_in_world) > 0.0 || area.DistanceTo(leg.To()) > 0.0) continue;
    legs.push_back(leg);
  }
  return legs;
}

std::optional<ChosenLeg> BestLeg(const std::vector<LegLine>& legs,
                                 const std::vector<LandingSquare>& squares,
                                 const KnownGround& ground,
                                 const LookFlight& flight,
                                 const NextLookOptions& options) {
  std::vector<double> values_now;
  values_now.reserve(squares.size());
  for (const LandingSquare& square : squares) {
    values_now.push_back(square.ValueAt(ground.known, options));
  }
  std::optional<ChosenLeg> best;
  const cv::Mat1f claims = ClaimsOf(squares, ground, options);
  for (const LegLine& leg : Shortlist(legs, claims, ground, flight, options)) {
    flight.before_leg();
    const LegViews views = ViewsOf(leg, flight.shape, flight.photo_spacing_m, ground.grid);
    cv::Mat1f known = KnownAfter(views, ground, options);
    double gain = 0.0;
    for (size_t i = 0; i < squares.size(); ++i) {
      if ((squares[i].cells & views.cells).empty()) continue;
      gain += squares[i].ValueAt(known, options) - values_now[i];
    }
    if (gain > (best ? best->expected_gain : 0.0)) best = ChosenLeg{leg, gain, std::move(known)};
  }
  return best;
}

}  // namespace freelsd
