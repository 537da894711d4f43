#include "engine/risk/risk.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/check/check.h"
#include "engine/risk/flight_errors.h"
#include "engine/risk/path_strip.h"

namespace freelsd {
namespace {

// Standard deviations of an error that a flight may have.
constexpr double kFarthestSds = 3.0;

// Probability that at least one of two independent things happens.
double Either(double a, double b) { return 1.0 - (1.0 - a) * (1.0 - b); }

// Standard deviations of what all cells share: the map's position and tilt (rise per metre), and
// the wind.
struct Spread {
  double position_m = 0.0;
  double tilt = 0.0;
  double wind_mps = 0.0;
};

// Everything that is the same for all flights of one landing.
struct Series {
  const PathStrip& strip;
  const PlannedLanding& landing;
  const Aircraft& aircraft;
  Spread spread;
  double error_length_m = 0.0;

  double Slope() const { return landing.approach_height / landing.approach_distance; }
};

// Where one flight goes, in the frame of the map.
struct Track {
  double along = 0.0;
  double across = 0.0;
  double tilt = 0.0;
  double ground_roll = 0.0;
};

Track TrackOf(const FlightErrors& errors, const Series& series) {
  const double radius = series.aircraft.touchdown_uncertainty_m;
  const double speed = series.landing.ground_speed;
  const double flown = std::max(0.0, speed + series.spread.wind_mps * errors.wind);
  const double ratio = speed > 0.0 ? flown / speed : 1.0;
  return {radius * errors.touchdown_along - series.spread.position_m * errors.shift_along,
          radius * errors.touchdown_across - series.spread.position_m * errors.shift_across,
          series.spread.tilt * errors.tilt,
          series.aircraft.ground_roll_m * ratio * ratio};
}

// Probability that the roll from `along` meets ground that is not fit. The kind of ground is one
// question for the whole roll, and its worst block answers it. Shapes of different blocks are
// different questions.
double RiskOfRoll(const Series& series, double along, double across, double length) {
  const PathStrip& strip = series.strip;
  const int col = strip.ColAt(across), last = strip.RowAt(along + length);
  const int block = std::max(1, static_cast<int>(series.error_length_m / strip.step));
  double kind = 0.0, fit_shape = 1.0;
  for (int row = strip.RowAt(along); row <= last; row += block) {
    const int end = std::min(row + block, last + 1);
    double sum_kind = 0.0, shape = 0.0;
    for (int i = row; i < end; ++i) {
      sum_kind += strip.kind(i, col);
      shape = std::max(shape, static_cast<double>(strip.shape(i, col)));
    }
    kind = std::max(kind, sum_kind / (end - row));
    fit_shape *= 1.0 - shape;
  }
  return 1.0 - (1.0 - kind) * fit_shape;
}

double RiskOfContact(const Series& series, int row, int col, double path_height) {
  const PathStrip& strip = series.strip;
  constexpr double kFarSds = 4.0, kLeastSd = 1e-3;
  const double above = strip.obstacle_top(row, col) - path_height;
  const double sd = std::max(kLeastSd, static_cast<double>(strip.obstacle_sd(row, col)));
  return above < -kFarSds * sd ? 0.0 : NormalCdf(above / sd);
}

// What one flight meets: probabilities of a failed final, and of a failed roll after it.
struct Met {
  double final_path = 0.0;
  double ground = 0.0;
};

// Heights of neighbouring cells err together, so each block of the final counts with its largest
// probability.
Met Fly(const Track& track, const Series& series) {
  const PathStrip& strip = series.strip;
  const int col = strip.ColAt(track.across), last = strip.RowAt(track.along);
  const int block = std::max(1, static_cast<int>(series.error_length_m / strip.step));
  double clear = 1.0, contact = 0.0;
  double landed_at = track.along;
  for (int row = 0; row < last; ++row) {
    const double before = track.along - strip.Along(row);
    const double height = (series.Slope() - track.tilt) * before;
    if (strip.ground_top(row, col) >= height) {
      landed_at = strip.Along(row);
      break;
    }
    contact = std::max(contact, RiskOfContact(series, row, col, height));
    if ((row + 1) % block != 0) continue;
    clear *= 1.0 - contact;
    contact = 0.0;
  }
  clear *= 1.0 - contact;
  return {1.0 - clear, RiskOfRoll(series, landed_at, track.across, track.ground_roll)};
}

struct MeanRisk {
  double all = 0.0;
  double ground = 0.0;
  double final_path = 0.0;
};

MeanRisk Average(const std::vector<FlightErrors>& flights, const Series& series) {
  MeanRisk mean;
  for (const FlightErrors& errors : flights) {
    const Met met = Fly(TrackOf(errors, series), series);
    mean.all += Either(met.final_path, met.ground);
    mean.ground += met.ground;
    mean.final_path += met.final_path;
  }
  const double share = 1.0 / static_cast<double>(flights.size());
  return {mean.all * share, mean.ground * share, mean.final_path * share};
}

StripExtent ExtentOf(const PlannedLanding& landing,
                     const Aircraft& aircraft,
                     const Spread& spread) {
  const double error = aircraft.touchdown_uncertainty_m + kFarthestSds * spread.position_m;
  const double speed = std::max(landing.ground_speed, 1.0);
  const double ratio = 1.0 + kFarthestSds * spread.wind_mps / speed;
  return {.behind = landing.approach_distance,
          .ahead = error + aircraft.ground_roll_m * ratio * ratio,
          .across = error};
}

// Probability that something reaches up to the circle. The aircraft keeps its height there within
// the safety margin in two deviations.
double RiskOfCircle(const RiskGround& ground,
                    const PlannedLanding& landing,
                    double error_length_m) {
  constexpr double kSdsOfMargin = 2.0;
  if (landing.loiter_radius <= 0.0) return 0.0;
  const Aircraft& aircraft = ground.aircraft;
  const double step = ground.map.grid.cell_size_m;
  const double flown_sd = aircraft.safety_margin_m / kSdsOfMargin;
  const double height = landing.touchdown_in_world.z() + landing.approach_height;
  const double half_width = aircraft.path_half_width_m;
  const int num_steps =
      std::max(8, static_cast<int>(std::ceil(2.0 * kPi * landing.loiter_radius / step)));
  const int block = std::max(1, static_cast<int>(error_length_m / step));
  double clear = 1.0, contact = 0.0;
  for (int i = 0; i < num_steps; ++i) {
    const double angle = 2.0 * kPi * i / num_steps;
    const Eigen::Vector2d out(std::cos(angle), std::sin(angle));
    for (double aside = -half_width; aside <= half_width; aside += step) {
      const std::optional<CellRisk> cell =
          ground.At(landing.loiter_center_in_world + (landing.loiter_radius + aside) * out);
      if (!cell) continue;
      const double sd = std::hypot(flown_sd, cell->top_sd);
      contact = std::max(contact, NormalCdf((cell->top - height) / sd));
    }
    if ((i + 1) % block != 0) continue;
    clear *= 1.0 - contact;
    contact = 0.0;
  }
  return 1.0 - clear * (1.0 - contact);
}

}  // namespace

void RiskOptions::Check() const {
  const FieldCheck check("approach");
  check.Inside("num_risk_flights", num_risk_flights, 1.0, 1e5);
  check.Inside("error_length_m", error_length_m, 0.1, 1000.0);
  check.Inside("unmeasured_wind_sd_mps", unmeasured_wind_sd_mps, 0.0, 20.0);
}

struct RiskAssessor::State {
  RiskGround ground;
  RiskOptions options;
  std::vector<FlightErrors> flights;

  bool IsKnown(const PlannedLanding& landing) const {
    return std::isfinite(landing.position_sd_m) && std::isfinite(ground.map.tilt_sd_deg);
  }
  Spread SpreadOf(const PlannedLanding& landing) const {
    constexpr double kSteepestDeg = 45.0;
    return {
        landing.position_sd_m,
        std::tan(RadFromDeg(std::min(ground.map.tilt_sd_deg, kSteepestDeg))),
        landing.wind_spread_mps > 0.0 ? landing.wind_spread_mps : options.unmeasured_wind_sd_mps};
  }
  PathStrip StripOf(const PlannedLanding& landing) const {
    return MakePathStrip(ground, landing, ExtentOf(landing, ground.aircraft, SpreadOf(landing)));
  }
  MeanRisk AverageOf(const PlannedLanding& landing,
                     const PathStrip& strip,
                     const Spread& spread) const {
    return Average(flights, {strip, landing, ground.aircraft, spread, options.error_length_m});
  }
  double CircleOf(const PlannedLanding& landing) const {
    return RiskOfCircle(ground, landing, options.error_length_m);
  }
};

RiskAssessor::RiskAssessor(const ElevationMap& map,
                           const HazardLayers& layers,
                           const Aircraft& aircraft,
                           const RiskOptions& options) {
  options.Check();
  state_ = std::make_unique<const State>(
      State{{map, layers, aircraft}, options, MakeFlightErrors(options.num_risk_flights)});
}

RiskAssessor::~RiskAssessor() = default;

double RiskAssessor::FailureProbability(const PlannedLanding& landing) const {
  if (!state_->IsKnown(landing)) return 1.0;
  const PathStrip strip = state_->StripOf(landing);
  const MeanRisk mean = state_->AverageOf(landing, strip, state_->SpreadOf(landing));
  return Either(mean.all, state_->CircleOf(landing));
}

LandingRisk RiskAssessor::Assess(const PlannedLanding& landing) const {
  if (!state_->IsKnown(landing)) return {};
  const Spread spread = state_->SpreadOf(landing);
  const PathStrip strip = state_->StripOf(landing);
  const auto average = [&](const Spread& errors) {
    return state_->AverageOf(landing, strip, errors);
  };
  const MeanRisk mean = average(spread);
  const double circle = state_->CircleOf(landing);
  const auto taken_off = [&](const MeanRisk& exact) { return std::max(0.0, mean.all - exact.all); };
  return {Either(mean.all, circle),
          {.ground = mean.ground,
           .final_path = mean.final_path,
           .circle = circle,
           .position = taken_off(average({0.0, 0.0, spread.wind_mps})),
           .wind = taken_off(average({spread.position_m, spread.tilt, 0.0}))}};
}

}  // namespace freelsd
