#include "tests/evaluation/frames/crop_pictures.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kCropM = 40.0;
constexpr int kCropSidePx = 280;
constexpr int kGapPx = 4;
constexpr size_t kNumColumns = 5;
constexpr double kMinShare = 0.15;

struct Crop {
  const LabelledPicture* picture = nullptr;
  cv::Rect area;
  // Of the area, showing the cover.
  double share = 0.0;
};

// The square that shows most of the cover.
std::optional<Crop> BestCrop(const LabelledPicture& picture, Cover cover) {
  const int side = cvRound(kCropM / picture.ground_sampling_m);
  if (side > std::min(picture.image.cols, picture.image.rows)) return std::nullopt;
  cv::Mat1i sums;
  cv::integral((picture.cover == static_cast<uint8_t>(cover)) / 255, sums, CV_32S);
  constexpr int kStepPx = 8;
  Crop best{&picture, {}, 0.0};
  for (int row = 0; row + side <= picture.image.rows; row += kStepPx) {
    for (int col = 0; col + side <= picture.image.cols; col += kStepPx) {
      const int count = sums(row + side, col + side) - sums(row, col + side) -
                        sums(row + side, col) + sums(row, col);
      const double share = static_cast<double>(count) / (static_cast<double>(side) * side);
      if (share > best.share) best = {&picture, cv::Rect(col, row, side, side), share};
    }
  }
  return best;
}

std::vector<Crop> BestCrops(const std::vector<LabelledPicture>& pictures,
                            const std::string& look,
                            Cover cover) {
  std::vector<Crop> crops;
  for (const LabelledPicture& picture : pictures) {
    if (picture.look != look) continue;
    const std::optional<Crop> crop = BestCrop(picture, cover);
    if (crop && crop->share >= kMinShare) crops.push_back(*crop);
  }
  std::stable_sort(
      crops.begin(), crops.end(), [](const Crop& a, const Crop& b) { return a.share > b.share; });
  // Photographs of all places, not the five of one flight.
  if (crops.size() <= kNumColumns) return crops;
  std::vector<Crop> taken;
  const size_t num_good = std::min(crops.size(), 2 * kNumColumns);
  for (size_t i = 0; i < kNumColumns; ++i) taken.push_back(crops[i * num_good / kNumColumns]);
  return taken;
}

void Draw(const Crop& crop, const cv::Point& corner, cv::Mat3b& sheet) {
  cv::Mat3b enlarged;
  cv::resize(crop.picture->image(crop.area),
             enlarged,
             {kCropSidePx, kCropSidePx},
             0,
             0,
             cv::INTER_NEAREST);
  enlarged.copyTo(sheet(cv::Rect(corner, enlarged.size())));
  for (const auto& [color, thickness] :
       {std::pair(cv::Scalar::all(0), 3), std::pair(cv::Scalar::all(255), 1)}) {
    cv::putText(sheet,
                crop.picture->name.substr(0, 36),
                corner + cv::Point(4, 12),
                cv::FONT_HERSHEY_SIMPLEX,
                0.38,
                color,
                thickness,
                cv::LINE_AA);
  }
}

}  // namespace

void DrawCrops(const std::string& folder,
               const std::vector<LabelledPicture>& pictures,
               const std::vector<std::string>& looks) {
  std::filesystem::create_directories(folder);
  const int step = kCropSidePx + kGapPx;
  for (const Cover cover : kComparedCovers) {
    cv::Mat3b sheet(static_cast<int>(looks.size()) * step,
                    static_cast<int>(kNumColumns) * step,
                    cv::Vec3b(0, 0, 0));
    bool is_empty = true;
    for (size_t row = 0; row < looks.size(); ++row) {
      const std::vector<Crop> crops = BestCrops(pictures, looks[row], cover);
      for (size_t col = 0; col < crops.size(); ++col) {
        Draw(crops[col], {static_cast<int>(col) * step, static_cast<int>(row) * step}, sheet);
        is_empty = false;
      }
    }
    if (!is_empty) cv::imwrite(folder + "/crops_" + CoverName(cover) + ".png", sheet);
  }
  for (const LabelledPicture& picture : pictures) {
    if (picture.look != kRecorded) {
      cv::imwrite(folder + "/" + picture.name + ".png", picture.image);
    }
  }
}

}  // namespace freelsd
