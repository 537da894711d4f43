// Cuts labelled photographs into regions.
#pragma once

#include <vector>

#include "server/training/labelled_photographs.h"

namespace freelsd {

// A photograph's regions, and its labels at the size of the working image.
struct LabelledRegions {
  Segments segments;
  cv::Mat1b mask;
  // For each segment, the class of most of its labelled pixels. Unlabelled if too few of its pixels
  // are labelled.
  std::vector<int> classes;
};
LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const SegmentationOptions& options,
                              double min_labelled_ratio);

// Whether ground of this class is surely grass or surely not.
bool TellsGrass(int surface_class);

}  // namespace freelsd
