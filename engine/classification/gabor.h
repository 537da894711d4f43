// The paper's Gabor responses, Sec. III-D.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

constexpr size_t kNumGaborWavelengths = 3;
// Half the side of the filters without their middle: margin that they need around a pixel.
constexpr int kGaborRadiusPx = 15;

// One filter per wavelength: the mean over the four directions. The paper leaves two points open.
// We take the mean pixel by pixel, which is one linear filter. A side of 31 px holds the relevant
// envelope across the wave (3.75 sigma).
std::array<cv::Mat1f, kNumGaborWavelengths> MeanGaborKernels();

// Responses to grey levels 0..255 where mask != 0; elsewhere 0 or the response. The image is
// mirrored at its border. Equals filtering with MeanGaborKernels up to rounding.
std::array<cv::Mat1f, kNumGaborWavelengths> GaborResponses(const cv::Mat1f& grey,
                                                           const cv::Mat1b& mask);

}  // namespace freelsd
