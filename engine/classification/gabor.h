// The paper's Gabor responses, Sec. III-D.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace freelsd {

constexpr size_t kNumGaborWavelengths = 3;
// The side of the filters is 2 * kGaborRadiusPx + 1 px.
constexpr int kGaborRadiusPx = 15;

// One filter per wavelength: the mean over the four directions. The paper does not specify how to
// combine the directions, nor the size of the filters. Here, the responses to the four directions
// are averaged for each pixel. This equals filtering once with the mean of the four filters. A
// radius of 15 px is 3.75 sigma of the envelope, measured at right angles to the stripes.
std::array<cv::Mat1f, kNumGaborWavelengths> MeanGaborKernels();

// Responses to grey levels 0..255. Only pixels with mask != 0 are sure to be computed; others may
// be 0. The image is mirrored at its border. Equals filtering with MeanGaborKernels up to rounding.
std::array<cv::Mat1f, kNumGaborWavelengths> GaborResponses(const cv::Mat1f& grey,
                                                           const cv::Mat1b& mask);

}  // namespace freelsd
