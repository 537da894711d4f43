// Input: a labelled picture. Output: numbers that say how each of its tiles looks.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/evaluation/frames/labelled_picture.h"

namespace freelsd {

struct TileOptions {
  // Scale at which pictures are compared: that of the paper's camera at 100 m.
  double ground_sampling_m = 0.215;
  double tile_m = 6.0;
  // Tiles keep this distance from the border of their cover.
  double margin_m = 0.5;
  // Of one cover on one picture, so that no picture outweighs the others.
  size_t max_num_tiles_per_picture = 60;

  // Throws std::invalid_argument.
  void Check() const;
};

// A band of sizes on the ground, metres.
struct Band {
  double fine_m = 0.0;
  double coarse_m = 0.0;
};
constexpr std::array<Band, 4> kBands{{{0.3, 0.6}, {0.6, 1.2}, {1.2, 2.5}, {2.5, 5.0}}};

// Side of the box that averages over `size_m`: the nearest odd number of pixels.
int BoxSidePx(double size_m, double ground_sampling_m);

cv::Mat1f LogBrightness(const cv::Mat3b& image);

// Mean of log brightness over a box of the band's fine size, less that over a box of its coarse
// size. Boxes average only what lies inside. 0 outside.
cv::Mat1f BandOf(const cv::Mat1f& log_brightness,
                 const cv::Mat1b& inside,
                 const Band& band,
                 double ground_sampling_m);

// In the order of MeasureNames(): contrast (standard deviation) in each band, mean grey level.
constexpr size_t kNumMeasures = kBands.size() + 1;
using Measures = std::array<double, kNumMeasures>;
const std::array<std::string, kNumMeasures>& MeasureNames();

// Tiles of each compared cover. The picture has options.ground_sampling_m.
std::map<Cover, std::vector<Measures>> MeasureTiles(const LabelledPicture& picture,
                                                    const TileOptions& options);

}  // namespace freelsd
