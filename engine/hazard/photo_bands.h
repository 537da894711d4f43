// Private to hazard/. A large picture in bands, so that what is worked out of it never needs more
// memory than a small one.
#pragma once

#include <vector>

#include "engine/hazard/hazard.h"

namespace freelsd {

struct PhotoBand {
  // Rows of the whole picture that the band answers for: from first to before end.
  int first_row = 0;
  int end_row = 0;
  // These rows and what lies within the halo, which the answer may depend on; pixels are shared.
  Orthophoto photo;
  // Of the whole picture, the band's row 0.
  int photo_first_row = 0;
};

// From north to south; a picture of ordinary size is one band.
std::vector<PhotoBand> BandsOf(const Orthophoto& photo, double halo_m);

}  // namespace freelsd
