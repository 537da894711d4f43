// Private to regions/: a segment that covers several fields, field by field.
#pragma once

#include <vector>

#include "engine/segmentation/segmentation.h"

namespace freelsd {

// The segment's pieces that hang together by more than `min_passage_m`, grown back to what lies
// nearest to each; the segment itself where there is but one. What is narrower everywhere stays
// one piece. Ground beyond the image's border counts as more of the same. Labels of the pieces are
// the segment's.
std::vector<Segment> PartsOf(const Segments& segments,
                             const Segment& segment,
                             double min_passage_m);

}  // namespace freelsd
