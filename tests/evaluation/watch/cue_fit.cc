#include "tests/evaluation/watch/cue_fit.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <Eigen/Dense>

#include "engine/watch/change.h"
#include "engine/watch/registration.h"
#include "tests/evaluation/watch/pass_file.h"

namespace freelsd {
namespace {

// A candidate belongs to a thing if it is as near as this: the map may lie beside the world.
constexpr double kMaxCandidateErrorM = 2.5;

std::vector<CueSample> SamplesOfPhoto(const StripPicture& strip,
                                      const PassPhoto& shot,
                                      bool is_quiet,
                                      const WatchOptions& options) {
  const WatchedPhoto photo = shot.Read();
  const StripGround ground(strip);
  const auto sampling = SamplingAt(photo, ground, ExtentOf(strip).Middle());
  if (!sampling) return {};
  const StripCanvas canvas = MakeCanvas(strip, *sampling, options);
  const auto registration = Register(photo, ground, canvas, options);
  if (!registration) return {};
  const ProjectedPhoto projected = Project(photo, ground, canvas, registration->displacement);
  const StripChange change =
      ChangeOf(canvas, projected, ComparableGround(canvas, ground, photo, options), options);
  std::vector<CueSample> samples;
  for (const ChangeCandidate& candidate : CandidatesIn(change, canvas, options)) {
    if (!StandsAlone(candidate, options)) continue;
    const Eigen::Vector2d place = canvas.PlaceAt(candidate.box.center.x, candidate.box.center.y);
    const bool is_thing =
        std::any_of(shot.shown_things.begin(), shot.shown_things.end(), [&](const auto& thing) {
          return (thing - place).norm() <= kMaxCandidateErrorM + 0.5 * candidate.length_m;
        });
    if (!is_thing && !is_quiet) continue;
    samples.push_back({CuesOf(candidate), is_thing, 1.0});
  }
  for (CueSample& sample : samples) {
    sample.weight = 1.0 / std::sqrt(static_cast<double>(samples.size()));
  }
  return samples;
}

using CueVector = Eigen::Matrix<double, kNumCues, 1>;
using CueMatrix = Eigen::Matrix<double, kNumCues, kNumCues>;

CueVector VectorOf(const CueSample& sample) {
  return Eigen::Map<const CueVector>(sample.cues.data());
}

// Deviation of each cue; that of the constant is 1.
CueVector DeviationsOf(const std::vector<CueSample>& samples) {
  CueVector sum = CueVector::Zero(), squares = CueVector::Zero();
  for (const CueSample& sample : samples) {
    sum += VectorOf(sample);
    squares += VectorOf(sample).cwiseAbs2();
  }
  const auto count = static_cast<double>(samples.size());
  CueVector deviations = (squares / count - (sum / count).cwiseAbs2()).cwiseMax(1e-6).cwiseSqrt();
  deviations[0] = 1.0;
  return deviations;
}

}  // namespace

std::vector<CueSample> SamplesOf(const std::string& folder, const WatchOptions& options) {
  std::vector<CueSample> samples;
  for (const std::string& file : PassFilesIn(folder)) {
    const RecordedPass pass = ReadPass(file);
    const StripPicture strip = ReadStrip(folder + "/" + pass.strip_file);
    for (const PassPhoto& shot : pass.photos) {
      const bool is_quiet = pass.plan.event == WatchEvent::kNone;
      const auto more = SamplesOfPhoto(strip, shot, is_quiet, options);
      samples.insert(samples.end(), more.begin(), more.end());
    }
  }
  return samples;
}

std::array<double, kNumCues> FitWeights(const std::vector<CueSample>& samples) {
  // Few worlds must not give large weights.
  constexpr double kRidge = 1.0;
  constexpr int kNumRounds = 25;
  const CueVector deviations = DeviationsOf(samples);
  CueVector weights = CueVector::Zero();
  for (int round = 0; round < kNumRounds; ++round) {
    CueVector gradient = -kRidge * weights;
    CueMatrix curvature = kRidge * CueMatrix::Identity();
    gradient[0] = 0.0;
    curvature(0, 0) = 0.0;
    for (const CueSample& sample : samples) {
      const CueVector cues = VectorOf(sample).cwiseQuotient(deviations);
      const double odds = 1.0 / (1.0 + std::exp(-weights.dot(cues)));
      gradient += sample.weight * ((sample.is_thing ? 1.0 : 0.0) - odds) * cues;
      curvature += sample.weight * odds * (1.0 - odds) * cues * cues.transpose();
    }
    weights += curvature.ldlt().solve(gradient);
  }
  std::array<double, kNumCues> result{};
  Eigen::Map<CueVector>(result.data()) = weights.cwiseQuotient(deviations);
  return result;
}

std::string CueReport(const std::vector<CueSample>& samples) {
  const std::array<double, kNumCues> weights = FitWeights(samples);
  std::ostringstream text;
  text << "weights:";
  for (const double weight : weights) text << ' ' << weight;
  int num_things = 0, num_wrong_things = 0, num_wrong_others = 0;
  for (const CueSample& sample : samples) {
    const double evidence = VectorOf(sample).dot(Eigen::Map<const CueVector>(weights.data()));
    num_things += sample.is_thing;
    num_wrong_things += sample.is_thing && evidence < 0.0;
    num_wrong_others += !sample.is_thing && evidence >= 0.0;
  }
  text << "\nthings: " << num_things << ", of these below 0: " << num_wrong_things
       << "\nothers: " << samples.size() - static_cast<size_t>(num_things)
       << ", of these above 0: " << num_wrong_others << '\n';
  return text.str();
}

}  // namespace freelsd
