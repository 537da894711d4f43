// Private to hazard/. A large picture in bands, so that what is worked out of it never needs more
// memory than a small one.
#pragma once

#include <functional>
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

// What `find` finds in each band, its halo included, put together: cells of the picture, 255 or 0.
cv::Mat1b FindInBands(const Orthophoto& photo,
                      double halo_m,
                      const std::function<cv::Mat1b(const PhotoBand&)>& find);

// Cells of the map on which any cell of the picture is found: 255, else 0.
cv::Mat1b OnMap(const cv::Mat1b& found, const Grid& grid);

}  // namespace freelsd
