// Changed parts of a strip that may be things, with what tells things from other changes.
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/watch/change.h"

namespace freelsd {

struct ChangeCandidate {
  Band band = Band::kBrightness;
  // Pixels of the canvas.
  cv::RotatedRect box;
  int num_pixels = 0;
  // Beside it lies something that is not shown: nobody knows how far it reaches.
  bool is_cut = false;
  // Largest on the strip, deviations.
  double deviations = 0.0;

  // --- What tells things from other changes ---
  // Mean of its band's change, deviations.
  double mean_deviations = 0.0;
  // Least share of its change against the ground around it that is left against the most similar
  // part of that ground. About 0 for a part of a larger shadow, because the shadow goes on.
  double isolation = 0.0;
  // Changes of the bands against the ground around it; and in the photograph alone.
  std::array<double, kNumBands> contrast{};
  std::array<double, kNumBands> own_contrast{};
  double length_m = 0.0;
  double width_m = 0.0;
  double area_m2 = 0.0;
  double on_strip_ratio = 0.0;
};

// Connected pixels of one band and sign that change at least by a level, for levels from
// grow_deviations on, as far as they touch the strip and are no longer than max_size_m. Most things
// are in it several times.
std::vector<ChangeCandidate> CandidatesIn(const StripChange& change,
                                          const StripCanvas& canvas,
                                          const WatchOptions& options);

// Neither part of a larger shadow, nor the place of a thing that is gone: that stands out in the
// stored picture and not in the photograph.
bool StandsAlone(const ChangeCandidate& candidate, const WatchOptions& options);

// Logarithm of the odds that a candidate that stands alone is a thing.
double EvidenceOf(const ChangeCandidate& candidate);

// What the evidence is a weighted sum of.
constexpr size_t kNumCues = 13;
std::array<double, kNumCues> CuesOf(const ChangeCandidate& candidate);

}  // namespace freelsd
