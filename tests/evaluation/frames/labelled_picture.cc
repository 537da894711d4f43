#include "tests/evaluation/frames/labelled_picture.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

namespace freelsd {

std::optional<LabelledPicture> AtScale(const LabelledPicture& picture, double ground_sampling_m) {
  const double scale = picture.ground_sampling_m / ground_sampling_m;
  if (scale > kMaxCoarserRatio) return std::nullopt;
  LabelledPicture scaled = picture;
  if (scale >= 1.0) return scaled;
  cv::resize(picture.image, scaled.image, {}, scale, scale, cv::INTER_AREA);
  cv::resize(picture.cover, scaled.cover, scaled.image.size(), 0, 0, cv::INTER_NEAREST);
  scaled.ground_sampling_m = ground_sampling_m;
  return scaled;
}

LabelledPicture Blurred(LabelledPicture picture, double lens_blur_px) {
  if (lens_blur_px <= 0.0) return picture;
  cv::Mat3b blurred;
  cv::GaussianBlur(picture.image, blurred, {}, lens_blur_px, lens_blur_px, cv::BORDER_REPLICATE);
  picture.image = blurred;
  return picture;
}

cv::Mat1b InsideOf(const LabelledPicture& picture, Cover cover, double margin_m) {
  cv::Mat1b inside = picture.cover == static_cast<uint8_t>(cover);
  const int margin_px = cvRound(margin_m / picture.ground_sampling_m);
  const int side_px = 2 * margin_px + 1;
  cv::erode(inside, inside, cv::Mat1b(side_px, side_px, uint8_t{1}));
  return inside;
}

std::vector<cv::Rect> TilesWithin(const cv::Mat1b& inside, int side_px, size_t max_num_tiles) {
  std::vector<cv::Rect> tiles;
  for (int row = 0; row + side_px <= inside.rows; row += side_px) {
    for (int col = 0; col + side_px <= inside.cols; col += side_px) {
      const cv::Rect tile(col, row, side_px, side_px);
      if (cv::countNonZero(inside(tile)) == tile.area()) tiles.push_back(tile);
    }
  }
  if (tiles.size() <= max_num_tiles) return tiles;
  std::vector<cv::Rect> taken;
  taken.reserve(max_num_tiles);
  for (size_t i = 0; i < max_num_tiles; ++i)
    taken.push_back(tiles[i * tiles.size() / max_num_tiles]);
  return taken;
}

}  // namespace freelsd
