// Photographs whose surfaces are known. Two layouts are read: a folder with images/NAME.jpg and
// masks/NAME.png, and flights with a table of outlined regions per flight (see label_sheets.h).
// Classes, in masks and tables: 0 unlabelled, 1 grass, 2 trees, 3 bracken, rushes and other tall
// growth, 4 crops, 5 soil and gravel, 6 paved, 7 building, 8 water, 9 dormant grass.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

constexpr int kUnlabelledClass = 0;
constexpr int kGrassClass = 1;
constexpr int kDormantGrassClass = 9;
constexpr int kNumClasses = 10;

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
  // Never split between training and validation.
  std::string place;
  cv::Mat3b image;
  // Class of each pixel.
  cv::Mat1b mask;
  Camera camera;
  double height_above_ground = 0.0;
};
using Photographs = std::vector<LabelledPhotograph>;

// All photographs of the folder that have a mask, in order of name. Prefixes that the cameras do
// not name are taken for a place of their own, at the mean scale of the others.
Photographs ReadLabelledPhotographs(const std::string& folder,
                                    const std::vector<LabelledCamera>& cameras);

// The photographs of flights/FLIGHT/images that tables/FLIGHT.csv names, for every table. Reduced
// to 0.15 m on the ground, so that all of them fit into memory.
Photographs ReadLabelledFlights(const std::string& flights,
                                const std::string& tables,
                                const std::vector<LabelledCamera>& cameras);

// The files of flights/FLIGHT/images, in order of name.
std::vector<std::filesystem::path> FlightPaths(const std::string& flights,
                                               const std::string& flight);

// One of them, without labels, at full size. Its name is FLIGHT__STEM.
LabelledPhotograph ReadFlightPhotograph(const std::filesystem::path& path,
                                        const std::string& flight,
                                        const std::vector<LabelledCamera>& cameras);

}  // namespace freelsd
