// Input: a sparse model of COLMAP, as text. Output: an adjusted block of ours.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/adjustment/adjustment.h"

namespace freelsd {

struct ColmapPoint {
  Eigen::Vector3d point_in_model = Eigen::Vector3d::Zero();
  // Names of the images that show it.
  std::vector<std::string> images;
};

// In the model's own frame and scale.
struct ColmapModel {
  Camera camera;
  std::map<std::string, Rigid3d> model_from_camera;
  std::vector<ColmapPoint> points;
};

// Reads cameras.txt, images.txt and points3D.txt in the folder. Throws std::runtime_error when they
// cannot be read, and unless all images are of one PINHOLE camera.
ColmapModel ReadColmapModel(const std::string& folder);

// Views and where their cameras are about, by name.
using Positions = std::map<std::string, Eigen::Vector3d>;

// Brought into world by the similarity that fits the positions best. Its views are those of
// `positions`, by name; the ones that the model does not hold are not connected. Throws
// std::runtime_error if the model has fewer than three of them.
AdjustedBlock BlockFrom(const ColmapModel& model, const Positions& positions);

}  // namespace freelsd
