// Makes training samples from labelled photographs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/training/labelled_photographs.h"

namespace freelsd {

// Changes to a copy of a photograph. They do not change its labels, so the forest learns to ignore
// such changes.
struct Variation {
  double exposure_ratio = 1.0;
  // White balance, relative to green.
  double red_ratio = 1.0;
  double blue_ratio = 1.0;
  // Distance of colours from grey. It differs more between cameras than between grass and trees.
  double saturation_ratio = 1.0;
  // Ground sampling distance of the working image relative to the default.
  double sampling_ratio = 1.0;
  // Ground sampling distance that the features assume, relative to the true one, because the height
  // above ground is only an estimate.
  double told_sampling_ratio = 1.0;
  double noise_sd_grey = 0.0;
  uint64_t noise_seed = 0;
};

// The unchanged photograph, then num_copies random variations that depend only on `seed`.
std::vector<Variation> Variations(int num_copies, uint64_t seed);

// A photograph's regions, and its labels at the size of the working image.
struct LabelledRegions {
  Segments segments;
  cv::Mat1b mask;
  // For each segment, the class of most of its labelled pixels. Unlabelled if too few of its pixels
  // are labelled.
  std::vector<int> classes;
};
LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const SegmentationOptions& options,
                              double min_labelled_ratio);
LabelledRegions CutVaried(const LabelledPhotograph& photograph,
                          const Variation& variation,
                          double min_labelled_ratio);

// RegionSamples: one sample for each region labelled as grass or not grass. TileSamples: one sample
// for each square tile in which nearly all pixels have one of these classes. A tile is tile_m wide
// on the ground.
std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions, FeatureSet feature_set);
std::vector<TrainingSample> TileSamples(const LabelledRegions& regions,
                                        FeatureSet feature_set,
                                        double tile_m);

// Samples from regions and tiles of every photograph and of num_copies variations of it.
std::vector<TrainingSample> SamplesOf(const Photographs& photographs,
                                      FeatureSet feature_set,
                                      int num_copies,
                                      int seed);

}  // namespace freelsd
