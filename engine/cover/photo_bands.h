// Private to cover/. Processes a large orthophoto in bands, so that working memory does not grow
// with its size.
#pragma once

#include <functional>
#include <vector>

#include "engine/cover/cover.h"

namespace freelsd {

struct PhotoBand {
  // The band's own rows in the whole orthophoto, end_row not included.
  int first_row = 0;
  int end_row = 0;
  // These rows and the halo that their result depends on; pixels are shared.
  Orthophoto photo;
  // Row of the whole orthophoto that is row 0 of `photo`.
  int photo_first_row = 0;
};

// From north to south; an orthophoto of ordinary size is one band.
std::vector<PhotoBand> BandsOf(const Orthophoto& photo, double halo_m);

// Joins what `find` returns for each band with its halo: cells of the orthophoto, 255 or 0.
cv::Mat1b FindInBands(const Orthophoto& photo,
                      double halo_m,
                      const std::function<cv::Mat1b(const PhotoBand&)>& find);

// Cells of the map that hold a found cell of the orthophoto: 255, else 0.
cv::Mat1b OnMap(const cv::Mat1b& found, const Grid& grid);

}  // namespace freelsd
