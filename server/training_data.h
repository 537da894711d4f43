// Labelled photographs -> training samples. Layout of a data folder: images/NAME.jpg and
// masks/NAME.png (8 bit, same size: 0 unlabelled, 1 grass, 2 to 8 other surfaces, 9 dormant grass).
#pragma once

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

// Whether samples are also taken in other exposures and light.
enum class Augmentation { kNone, kPhotometric };

// Regions found by the segmentation, labelled by the majority of their labelled pixels; regions of
// which less than min_labelled_ratio is labelled, or that are mostly dormant grass, are left out.
std::vector<TrainingSample> RegionSamples(const LabelledPhotograph& photograph,
                                          FeatureSet feature_set,
                                          double min_labelled_ratio,
                                          Augmentation augmentation);

// Square tiles of tile_m on the ground, half a tile apart, whose pixels all carry one label.
std::vector<TrainingSample> TileSamples(const LabelledPhotograph& photograph,
                                        FeatureSet feature_set,
                                        double tile_m,
                                        Augmentation augmentation);

}  // namespace freelsd
