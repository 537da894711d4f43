#include "engine/watch/new_things.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/watch/candidates.h"

namespace freelsd {
namespace {

bool IsOfOtherColor(const ChangeCandidate& candidate) {
  // Changes of the light are smaller.
  constexpr double kLeastGreen = 0.06, kLeastRedBlue = 0.3;
  return std::abs(candidate.contrast[static_cast<size_t>(Band::kGreenExcess)]) >= kLeastGreen ||
         std::abs(candidate.contrast[static_cast<size_t>(Band::kRedBlue)]) >= kLeastRedBlue;
}

NewThing ThingOf(const ChangeCandidate& candidate,
                 double evidence,
                 const StripCanvas& canvas,
                 const StripGround& ground) {
  NewThing thing;
  thing.cue = IsOfOtherColor(candidate) ? WatchCue::kColor : WatchCue::kShade;
  const Eigen::Vector2d place = canvas.PlaceAt(candidate.box.center.x, candidate.box.center.y);
  thing.place_in_world << place, ground.HeightAt(place);
  thing.length_m = candidate.length_m;
  thing.width_m = candidate.width_m;
  thing.area_m2 = candidate.area_m2;
  thing.deviations = candidate.deviations;
  thing.evidence = evidence;
  return thing;
}

// One of the two is a part of the other, or its shadow.
bool IsSame(const NewThing& a, const NewThing& b) {
  const double distance = (a.place_in_world - b.place_in_world).head<2>().norm();
  return distance <= 0.5 * (a.length_m + b.length_m);
}

// Pixels of the strip whose colours changed over more than the size of a thing.
int NumChangedGround(const StripChange& change,
                     const StripCanvas& canvas,
                     const WatchOptions& options) {
  const cv::Mat1f& deviations = change.Of(Band::kGreenExcess).deviations;
  const double most_px = options.max_size_m / canvas.grid.cell_size_m;
  int num_changed = 0;
  for (const float sign : {1.0f, -1.0f}) {
    cv::Mat1i labels, stats;
    cv::Mat1d centers;
    const cv::Mat1b is_changed = sign * deviations >= options.grow_deviations;
    const int count = cv::connectedComponentsWithStats(is_changed, labels, stats, centers, 8);
    for (int i = 1; i < count; ++i) {
      const cv::Rect box(stats(i, cv::CC_STAT_LEFT),
                         stats(i, cv::CC_STAT_TOP),
                         stats(i, cv::CC_STAT_WIDTH),
                         stats(i, cv::CC_STAT_HEIGHT));
      if (std::max(box.width, box.height) <= most_px) continue;
      num_changed += cv::countNonZero((labels(box) == i) & change.is_compared(box));
    }
  }
  return num_changed;
}

}  // namespace

NewThings ThingsIn(const StripChange& change,
                   const StripCanvas& canvas,
                   const StripGround& ground,
                   const WatchOptions& options) {
  NewThings result;
  result.num_changed_ground = NumChangedGround(change, canvas, options);
  std::vector<NewThing> things;
  for (const ChangeCandidate& candidate : CandidatesIn(change, canvas, options)) {
    const double evidence = EvidenceOf(candidate);
    if (evidence < options.min_evidence || !StandsAlone(candidate, options)) continue;
    things.push_back(ThingOf(candidate, evidence, canvas, ground));
  }
  std::stable_sort(things.begin(), things.end(), [](const NewThing& a, const NewThing& b) {
    return a.evidence > b.evidence;
  });
  for (const NewThing& thing : things) {
    const bool is_known = std::any_of(result.things.begin(),
                                      result.things.end(),
                                      [&](const NewThing& other) { return IsSame(thing, other); });
    if (!is_known) result.things.push_back(thing);
  }
  return result;
}

}  // namespace freelsd
