// Input: a grey image. Output: the image blurred ever more, octave by octave (Lowe 2004, Sec. 3).
#pragma once

#include <array>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

constexpr int kNumScalesPerOctave = 3;
// Blur of the first layer of every octave, in the octave's pixels.
constexpr float kFirstSigmaPx = 1.6F;

// Layer i is blurred by kFirstSigmaPx * 2^(i / kNumScalesPerOctave), in pixels of the octave.
struct Octave {
  std::array<cv::Mat1f, kNumScalesPerOctave + 3> layers;
};

// The first octave has twice the image's width, each next one half of the octave's before. Ends
// where less than `min_side_px` would be left.
std::vector<Octave> ScaleSpaceOf(const cv::Mat1b& grey, int min_side_px);

}  // namespace freelsd
