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
  // The band's own rows, and a halo: the rows around them that influence their result. Shares
  // pixels with the whole orthophoto.
  Orthophoto photo;
  // Row of the whole orthophoto that is row 0 of `photo`.
  int photo_first_row = 0;
};

// Bands from north to south. An orthophoto of ordinary size is one band.
std::vector<PhotoBand> BandsOf(const Orthophoto& photo, double halo_m);

// Calls `find` for each band and joins the results without halos. One value per cell of the
// orthophoto: 255 or 0.
cv::Mat1b FindInBands(const Orthophoto& photo,
                      double halo_m,
                      const std::function<cv::Mat1b(const PhotoBand&)>& find);

// One value per map cell: 255 if the cell contains a found cell of the orthophoto, else 0.
cv::Mat1b OnMap(const cv::Mat1b& found, const Grid& grid);

}  // namespace freelsd
