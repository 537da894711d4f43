// The paper's Gabor responses, Sec. III-D.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

constexpr size_t kNumGaborWavelengths = 3;
// Half the side of the filters without their middle: room that they need around a pixel.
constexpr int kGaborRadiusPx = 15;

// One filter per wavelength, the mean over the four directions. Readings where the paper is silent:
// the mean is taken pixel by pixel, and a mean of linear filters is one linear filter; a side of 31
// px holds all of the envelope that matters across the wave (3.75 sigma).
std::array<cv::Mat1f, kNumGaborWavelengths> MeanGaborKernels();

// Responses of grey levels 0..255 where mask != 0; elsewhere 0 or the response. Beyond the border
// the image is mirrored. The same as filtering with MeanGaborKernels but for rounding.
std::array<cv::Mat1f, kNumGaborWavelengths> GaborResponses(const cv::Mat1f& grey,
                                                           const cv::Mat1b& mask);

}  // namespace freelsd
