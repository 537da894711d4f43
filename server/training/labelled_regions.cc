#include "server/training/labelled_regions.h"

#include <algorithm>
#include <array>
#include <numeric>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

using ClassCounts = std::array<int, kNumClasses>;

// Number of pixels of each class where `inside` is set.
ClassCounts CountClasses(const cv::Mat1b& mask, const cv::Mat1b& inside) {
  ClassCounts counts{};
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (inside(y, x) != 0 && mask(y, x) < kNumClasses) ++counts[mask(y, x)];
    }
  }
  return counts;
}

int MajorityClass(const ClassCounts& counts, double min_labelled_ratio) {
  const int num_pixels = std::accumulate(counts.begin(), counts.end(), 0);
  const int num_labelled = num_pixels - counts[kUnlabelledClass];
  if (num_labelled == 0 || num_labelled < min_labelled_ratio * num_pixels) return kUnlabelledClass;
  return static_cast<int>(std::max_element(counts.begin() + 1, counts.end()) - counts.begin());
}

}  // namespace

LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const SegmentationOptions& options,
                              double min_labelled_ratio) {
  LabelledRegions regions;
  regions.segments =
      SegmentFrame(photograph.image, photograph.camera, photograph.height_above_ground, options);
  cv::resize(photograph.mask, regions.mask, regions.segments.image.size(), 0, 0, cv::INTER_NEAREST);
  for (const Segment& segment : regions.segments.segments) {
    const cv::Mat1b inside = regions.segments.labels == segment.label;
    regions.classes.push_back(
        MajorityClass(CountClasses(regions.mask, inside), min_labelled_ratio));
  }
  return regions;
}

bool TellsGrass(int surface_class) {
  return surface_class != kUnlabelledClass && surface_class != kDormantGrassClass;
}

}  // namespace freelsd
