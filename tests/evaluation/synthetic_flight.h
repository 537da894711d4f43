// Input: a seed. Output: a world, an aircraft, and the frames of a flight over it as an engine gets
// them.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/flight/flight.h"
#include "server/training/pools.h"
#include "tests/synthetic/flight_plan.h"
#include "tests/synthetic/world.h"

namespace freelsd {

struct ScenarioOptions {
  // Larger than what the flight sees: beyond the world there is no truth.
  double world_size_m = 500.0;
  double cell_size_m = 0.2;
  // East and north of the middle of WorldOptions: worlds side by side are a mosaic.
  double east_m = 0.0;
  double north_m = 0.0;
  // Real ground that lies in the world: a pack of $FREELSD_DATA/terrain, or "tuning" or "report"
  // for all packs of that pool in turns; "" for painted countryside alone.
  std::string ground;
  // "painted", or "recorded": the covers wear textures of the seed's pool.
  std::string texture = "painted";
  // "plain", or "recorded": light, air and camera as recorded flights show them.
  std::string conditions = "plain";
  // Nothing: as many as cover the ground that a spacing is flown over (NumFramesAt).
  std::optional<int> num_frames;
  double height_m = 100.0;
  // Between two photographs. 30 m is an overlap of 0.71 along the track, for the paper's
  // down-looking camera; beside it the legs overlap by 0.63. Nothing: one of kSpacingsM
  // (SpacingFor).
  std::optional<double> frame_spacing_m = 30.0;
  double leg_spacing_m = 60.0;
  double noise_scale = 1.0;
  // Share of the photographs that are damaged: half black, burnt out, smeared, or another's.
  double damaged_ratio = 0.0;
  // The planner is given the world's power lines as obstacles.
  bool gives_wires = false;
  // Without, the flight is planned and nothing is photographed.
  bool takes_photographs = true;
  // "techpod", "small"; "both" takes one after the other from seed to seed.
  std::string aircraft = "both";
  int num_threads = 1;

  // Throws std::invalid_argument.
  void Check() const;
};

// Spacings that cameras have: a photograph in half a second, in a second, and a survey's.
constexpr std::array<double, 3> kSpacingsM{6.0, 13.0, 30.0};
// Metres. Mixed spacings go hand in hand with neither aircraft nor window of real ground: of six
// seeds from a multiple of six, each spacing is flown by both aircraft.
double SpacingFor(uint64_t seed, const ScenarioOptions& options);
// The default number of photographs: 50 at 30 m, 72 at 13 m and 156 at 6 m.
int NumFramesAt(double spacing_m);

struct Scenario {
  World world;
  // Pack and window of real ground, "iquitos_pe/clearing"; "" for painted countryside.
  std::string ground;
  Aircraft aircraft;
  Rig rig;
  // Metres between two photographs.
  double frame_spacing_m = 0.0;
  std::vector<SyntheticExposure> exposures;
  // Same order as exposures; ids are the image names. Empty without photographs.
  std::vector<Frame> frames;
  // Cells of 1 m, row 0 south, that at least three photographs see, 255 or 0.
  cv::Mat1b seen;

  Rigid3d TrueWorldFromCamera(size_t exposure) const;
};

// Who may see what. From tests/evaluation/pools.csv.
const Pools& EvaluationPools();
// File of the network that learned nothing from this flight or place: that of its fold (folds/).
// Nothing where it has none.
std::optional<std::string> FoldModelOf(const std::string& name);

// `progress` is called with the share of the photographs that are rendered. 0 means that the world
// is built.
Scenario MakeScenario(uint64_t seed,
                      const ScenarioOptions& options,
                      const std::function<void(double)>& progress);

}  // namespace freelsd
