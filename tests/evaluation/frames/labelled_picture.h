// Input: a picture from above and what its pixels show. Output: the same at another scale, and its
// square tiles that show one cover alone.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "tests/synthetic/world.h"

namespace freelsd {

// A photograph or a rendered frame.
struct LabelledPicture {
  std::string name;
  // Where it comes from: kRecorded or one of the looks of worlds.
  std::string look;
  cv::Mat3b image;
  // Cover of each pixel; kDoubt where nobody says what it shows.
  cv::Mat1b cover;
  double ground_sampling_m = 0.0;
};

constexpr const char* kRecorded = "recorded";

// Covers that both photographs and worlds show.
constexpr std::array<Cover, 9> kComparedCovers{Cover::kMeadow,
                                               Cover::kScrub,
                                               Cover::kCrop,
                                               Cover::kStubble,
                                               Cover::kSoil,
                                               Cover::kWater,
                                               Cover::kTree,
                                               Cover::kBareTree,
                                               Cover::kRoad};

// Reduced by area averaging. Empty if the picture is coarser than that by more than
// kMaxCoarserRatio; one that is coarser by less keeps its pixels.
constexpr double kMaxCoarserRatio = 1.15;
std::optional<LabelledPicture> AtScale(const LabelledPicture& picture, double ground_sampling_m);

// As a lens blurs it: a Gaussian with that deviation; 0: unchanged.
LabelledPicture Blurred(LabelledPicture picture, double lens_blur_px);

// 255 where the picture shows the cover and its border is at least `margin_m` away.
cv::Mat1b InsideOf(const LabelledPicture& picture, Cover cover, double margin_m);

// Squares of a lattice that lie wholly inside. Of more than `max_num_tiles`, so many are taken at
// equal steps.
std::vector<cv::Rect> TilesWithin(const cv::Mat1b& inside, int side_px, size_t max_num_tiles);

}  // namespace freelsd
