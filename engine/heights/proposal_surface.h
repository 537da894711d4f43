// Private to heights/. The surface from which heights are searched up and down.
#pragma once

#include "engine/terrain/terrain.h"

namespace freelsd {

// Lower envelope of the map's elevation, without outliers and without what is narrower than the
// window. Continues a window's width over unseen cells; NaN beyond.
class ProposalSurface {
 public:
  ProposalSurface(const ElevationMap& map, double window_m);
  // World z, linear between cell centres; rows and columns as of cv::Mat, (0, 0) is the centre of
  // the first cell. NaN where unknown. Outside the grid the edge repeats.
  double At(double row, double col) const;

 private:
  cv::Mat1f height_;
};

}  // namespace freelsd
