// Input: a grey image. Output: points that are found again in other images, each with what tells it
// from others (Lowe 2004).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/tracks/scale_space.h"

namespace freelsd {

// A place that is brighter or darker than its surroundings on one scale.
struct Blob {
  // Index of its octave, and of the layer in it.
  int octave = 0;
  int layer = 0;
  // In pixels of the octave: the nearest, and between them.
  cv::Point nearest;
  cv::Point2f place;
  float sigma_px = 0.0F;
  // How far it stands out, in shares of the full range of grey levels.
  float contrast = 0.0F;

  // In pixels of the image.
  cv::Point2f PlaceInImage() const;
};

// One row of the descriptor's 4 x 4 histograms over 8 directions, normalised.
constexpr int kNumDescriptorEntries = 128;
using Descriptor = std::array<uint8_t, kNumDescriptorEntries>;

// Octaves with a shorter side have no blobs.
constexpr int kMinOctaveSidePx = 11;

// Those that stand out most first; equal ones from left to right.
std::vector<Blob> FindBlobs(const std::vector<Octave>& octaves, float min_contrast);

// Directions that the grey levels around a blob rise in, degrees in [0, 360), the largest first;
// most often one.
std::vector<float> DirectionsOf(const Blob& blob, const std::vector<Octave>& octaves);

Descriptor Describe(const Blob& blob, float direction_deg, const std::vector<Octave>& octaves);

}  // namespace freelsd
