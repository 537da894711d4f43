#include "engine/adjustment/evidence.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

namespace freelsd {
namespace {

// Change of Schwarz's criterion if the cost falls from `without` to `with`. The scale of the
// residuals is unknown.
double Gain(double without, double with, int num_residuals, size_t num_parameters) {
  const double n = num_residuals;
  return n * std::log(without / with) - static_cast<double>(num_parameters) * std::log(n);
}

// Turn at the first and last row by one power, degrees, root mean square over the views.
double TurnDeg(const std::vector<Readout>& readouts, int power) {
  double sum = 0.0;
  for (const Readout& readout : readouts) sum += readout.turns.col(power - 1).squaredNorm();
  return DegFromRad(std::sqrt(sum / static_cast<double>(readouts.size())) * std::pow(0.5, power));
}

class Chooser {
 public:
  Chooser(const std::vector<View>& views,
          const Camera& camera,
          const AdjustmentOptions& options,
          ChosenBlock start)
      : views_(views), camera_(camera), options_(options), chosen_(std::move(start)) {}

  // Drops the only power of the turn if it does not pay for itself.
  void TryWithoutTurn() {
    std::optional<ChosenBlock> still = Solve(0);
    if (!still) return;
    const bool is_kept = Tell(1, still->solved, chosen_.solved);
    if (!is_kept) Take(std::move(*still));
  }

  void TryMoreTurns() {
    while (chosen_.settings.num_turns > 0 &&
           chosen_.settings.num_turns < options_.max_readout_power) {
      const int power = chosen_.settings.num_turns + 1;
      std::optional<ChosenBlock> more = Solve(power);
      if (!more) return;
      const bool is_kept = Tell(power, chosen_.solved, more->solved);
      if (!is_kept) return;
      Take(std::move(*more));
    }
  }

  ChosenBlock Chosen() && { return std::move(chosen_); }

 private:
  std::optional<ChosenBlock> Solve(int num_turns) const {
    ChosenBlock trial{{}, chosen_.settings, chosen_.tracks, {}};
    trial.settings.num_turns = num_turns;
    const std::optional<SolvedBlock> solved =
        SolveBlock(views_,
                   camera_,
                   Restricted(chosen_.solved.state, trial.settings),
                   options_,
                   trial.settings,
                   trial.tracks);
    if (!solved) return std::nullopt;
    trial.solved = *solved;
    return trial;
  }

  // Three parameters per view.
  bool Tell(int power, const SolvedBlock& without, const SolvedBlock& with) {
    const double gain = Gain(without.cost, with.cost, with.num_residuals, 3 * views_.size());
    chosen_.evidence.push_back({"readout.turn^" + std::to_string(power),
                                TurnDeg(with.state.readouts, power),
                                gain,
                                gain > 0.0});
    return gain > 0.0;
  }

  void Take(ChosenBlock trial) {
    trial.evidence = std::move(chosen_.evidence);
    chosen_ = std::move(trial);
  }

  const std::vector<View>& views_;
  const Camera& camera_;
  const AdjustmentOptions& options_;
  ChosenBlock chosen_;
};

}  // namespace

std::string AdjustedBlock::EvidenceNote() const {
  std::ostringstream text;
  text << std::fixed;
  for (const ParameterEvidence& each : evidence) {
    text << (text.tellp() > 0 ? "; " : "") << each.name << (each.is_kept ? " kept: " : " dropped: ")
         << std::setprecision(3) << each.turn_deg << " deg, BIC gain " << std::setprecision(0)
         << each.gain;
  }
  return text.str();
}

SolverSettings WithFirstTurns(SolverSettings settings,
                              const Camera& camera,
                              const AdjustmentOptions& options) {
  const bool is_unknown = IsReadoutUnknown(camera);
  const bool is_rolling = is_unknown ? options.exif_readout_s > 0.0 : camera.readout_s > 0.0;
  settings.num_turns = is_rolling ? std::min(is_unknown ? 1 : 2, options.max_readout_power) : 0;
  return settings;
}

BlockState Restricted(BlockState state, const SolverSettings& settings) {
  for (Readout& readout : state.readouts) {
    readout.turns.rightCols(Readout::kNumTurns - settings.num_turns).setZero();
  }
  return state;
}

ChosenBlock ChooseReadout(const std::vector<View>& views,
                          const Camera& camera,
                          const AdjustmentOptions& options,
                          ChosenBlock start) {
  if (start.settings.num_turns == 0) return start;
  const bool is_unknown = IsReadoutUnknown(camera);
  Chooser chooser(views, camera, options, std::move(start));
  // Without a stated time, uneven turns bend the block (decision 0007).
  if (is_unknown) {
    chooser.TryWithoutTurn();
  } else {
    chooser.TryMoreTurns();
  }
  return std::move(chooser).Chosen();
}

}  // namespace freelsd
