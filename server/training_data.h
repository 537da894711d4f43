// Labelled photographs -> training samples. Layout of a data folder: images/NAME.jpg and
// masks/NAME.png (8 bit, same size: 0 unlabelled, 1 grass, 2 to 8 other surfaces, 9 dormant grass).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

// One line of the cameras file: how large the photographs of one prefix are on the ground.
struct LabelledCamera {
  std::string prefix;
  std::string place;
  double focal_ratio = 0.0;
  double height_m = 0.0;
};

// Throws std::runtime_error naming the line that cannot be read.
std::vector<LabelledCamera> ReadLabelledCameras(const std::string& path);

struct LabelledPhotograph {
  std::string name;
  std::string place;
  cv::Mat3b image;
  cv::Mat1b mask;
  Camera camera;
  double height_above_ground = 0.0;
};

// All photographs of the folder that have a mask, in order of name. Prefixes that the cameras do
// not name are taken for a place of their own, at the mean scale of the others.
std::vector<LabelledPhotograph> ReadLabelledPhotographs(const std::string& folder,
                                                        const std::vector<LabelledCamera>& cameras);

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
  // One per segment: is it grass, by the majority of its labelled pixels? Nothing where too few of
  // them are labelled, or most are dormant grass.
  std::vector<std::optional<bool>> is_grass;
};
LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const Variation& variation,
                              double min_labelled_ratio);

std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions, FeatureSet feature_set);

// Square tiles of tile_m on the ground whose pixels nearly all carry one label, grass or not.
std::vector<TrainingSample> TileSamples(const LabelledRegions& regions,
                                        FeatureSet feature_set,
                                        double tile_m);

}  // namespace freelsd
