// Reads photographs with labelled surfaces, in two layouts: a folder with images/NAME.jpg and
// masks/NAME.png, or flights with one table of outlined regions each (see label_sheets.h). Classes
// in masks and tables: 0 unlabelled, 1 grass, 2 trees, 3 tall growth (bracken, rushes and others),
// 4 crops, 5 soil and gravel, 6 paved, 7 building, 8 water, 9 dormant grass.
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

// One line of the cameras file. It gives the place and the ground scale of photographs whose names
// begin with `prefix`.
struct LabelledCamera {
  std::string prefix;
  std::string place;
  double focal_ratio = 0.0;
  double height_m = 0.0;
};

// Throws std::runtime_error that names the file or the line that cannot be read.
std::vector<LabelledCamera> ReadLabelledCameras(const std::string& path);

// A photograph with its labels and its ground scale.
struct LabelledPhotograph {
  std::string name;
  // When a place is left out for validation, none of its photographs are used for training.
  std::string place;
  cv::Mat3b image;
  // Class of each pixel.
  cv::Mat1b mask;
  Camera camera;
  double height_above_ground = 0.0;
};
using Photographs = std::vector<LabelledPhotograph>;

// All photographs of the folder, sorted by name. Throws std::runtime_error if one has no mask of
// the same size. If no prefix in `cameras` fits the name of a photograph, its place is its name up
// to "__", and its scale is the mean scale of `cameras`.
Photographs ReadLabelledPhotographs(const std::string& folder,
                                    const std::vector<LabelledCamera>& cameras);

// For each table, the photographs in flights/FLIGHT/images that tables/FLIGHT.csv names. They are
// reduced to 0.15 m per pixel, so that all fit into memory.
Photographs ReadLabelledFlights(const std::string& flights,
                                const std::string& tables,
                                const std::vector<LabelledCamera>& cameras);

// The files of flights/FLIGHT/images, sorted by name.
std::vector<std::filesystem::path> FlightPaths(const std::string& flights,
                                               const std::string& flight);

// One photograph, without labels, at full size. Its name is FLIGHT__STEM.
LabelledPhotograph ReadFlightPhotograph(const std::filesystem::path& path,
                                        const std::string& flight,
                                        const std::vector<LabelledCamera>& cameras);

}  // namespace freelsd
