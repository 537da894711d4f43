#include "engine/cover/photo_bands.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Cells of a band: an eighth of a square kilometre at 0.25 m. Some rules need 20 rasters of floats
// for a band.
constexpr int kMaxNumCells = 2000000;

}  // namespace

std::vector<PhotoBand> BandsOf(const Orthophoto& photo, double halo_m) {
  std::vector<PhotoBand> bands;
  if (photo.image.empty()) return bands;
  const int num_rows = photo.image.rows;
  const int height = std::max(1, kMaxNumCells / photo.image.cols);
  const int halo = static_cast<int>(std::ceil(halo_m / photo.grid.cell_size_m));
  for (int first = 0; first < num_rows; first += height) {
    PhotoBand band;
    band.first_row = first;
    band.end_row = std::min(num_rows, first + height);
    band.photo_first_row = std::max(0, first - halo);
    const cv::Range rows(band.photo_first_row, std::min(num_rows, band.end_row + halo));
    band.photo.grid = photo.grid;
    band.photo.grid.north_west_in_world.y() -= rows.start * photo.grid.cell_size_m;
    band.photo.grid.num_rows = rows.size();
    band.photo.image = photo.image.rowRange(rows);
    band.photo.seen = photo.seen.rowRange(rows);
    bands.push_back(std::move(band));
  }
  return bands;
}

cv::Mat1b FindInBands(const Orthophoto& photo,
                      double halo_m,
                      const std::function<cv::Mat1b(const PhotoBand&)>& find) {
  cv::Mat1b found = cv::Mat1b::zeros(photo.image.size());
  for (const PhotoBand& band : BandsOf(photo, halo_m)) {
    const cv::Range own(band.first_row, band.end_row);
    find(band).rowRange(own - band.photo_first_row).copyTo(found.rowRange(own));
  }
  return found;
}

cv::Mat1b OnMap(const cv::Mat1b& found, const Grid& grid) {
  cv::Mat1b share;
  cv::resize(found, share, {grid.num_cols, grid.num_rows}, 0.0, 0.0, cv::INTER_AREA);
  return share > 0;
}

}  // namespace freelsd
