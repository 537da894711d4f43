// Labelled photographs -> training samples.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/labelled_photographs.h"

namespace freelsd {

// How a copy of a photograph differs, so that a forest learns what does not matter.
struct Variation {
  double exposure_ratio = 1.0;
  // White balance, relative to green.
  double red_ratio = 1.0;
  double blue_ratio = 1.0;
  // Distance of colours from grey: cameras differ in it more than grass from trees.
  double saturation_ratio = 1.0;
  // Ground sampling distance of the working image relative to the default.
  double sampling_ratio = 1.0;
  // Ground sampling distance told to the features relative to the true one: heights are guesses.
  double told_sampling_ratio = 1.0;
  double noise_sd_grey = 0.0;
  uint64_t noise_seed = 0;
};

// The photograph as it is, then num_copies seeded variations of it.
std::vector<Variation> Variations(int num_copies, uint64_t seed);

// A photograph cut into regions and the labels at the size of its working image.
struct LabelledRegions {
  Segments segments;
  cv::Mat1b mask;
  // One per segment: the class of most of its labelled pixels; unlabelled where too few of them
  // are labelled.
  std::vector<int> classes;
};
LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const SegmentationOptions& options,
                              double min_labelled_ratio);
LabelledRegions CutVaried(const LabelledPhotograph& photograph,
                          const Variation& variation,
                          double min_labelled_ratio);

// The regions of classes that say whether there is grass, and the square tiles of tile_m on the
// ground whose pixels nearly all carry one such label.
std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions, FeatureSet feature_set);
std::vector<TrainingSample> TileSamples(const LabelledRegions& regions,
                                        FeatureSet feature_set,
                                        double tile_m);

// Regions and tiles of every photograph and of num_copies variations of it.
std::vector<TrainingSample> SamplesOf(const Photographs& photographs,
                                      FeatureSet feature_set,
                                      int num_copies,
                                      int seed);

}  // namespace freelsd
