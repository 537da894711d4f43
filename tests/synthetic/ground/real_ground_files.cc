// Reading a pack: what its rasters and outlines say.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/ground/real_ground.h"

namespace freelsd {
namespace {

// The narrower side of crowns and cars, and of all that stands on the ground: a school's roof. A
// wider disc also takes the tops off banks.
constexpr double kWidestCrownM = 12.0;
constexpr double kWidestRoofM = 24.0;
// Bare ground is sought, and smoothed, on cells of this size.
constexpr double kBareCellM = 1.0;
constexpr float kNowhere = 1e6f;
// Whatever an outline says, what stands higher than this is none of the grass.
constexpr double kTallestGrassM = 0.4;
constexpr double kTallM = 2.0;
constexpr float kUnknownHeight = -9999.0f;

std::string FolderOf(const std::string& pack) {
  const char* data = std::getenv("FREELSD_DATA");
  if (data == nullptr) {
    throw std::runtime_error("ground " + pack +
                             ": FREELSD_DATA is not set; its folder holds terrain/" + pack);
  }
  const std::filesystem::path folder = std::filesystem::path(data) / "terrain" / pack;
  if (!std::filesystem::is_directory(folder)) {
    throw std::runtime_error("ground " + pack + ": there is no " + folder.string());
  }
  return folder.string();
}

std::ifstream Open(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return file;
}

cv::Mat ReadRaster(const std::string& path, int type) {
  cv::Mat raster = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (raster.empty()) throw std::runtime_error("cannot read " + path);
  if (raster.type() != type) {
    throw std::runtime_error(path + ": pixels are " + cv::typeToString(raster.type()) + ", not " +
                             cv::typeToString(type));
  }
  return raster;
}

double MedianOf(const cv::Mat1f& values, const cv::Mat1b& is_known) {
  std::vector<float> known;
  for (int row = 0; row < values.rows; ++row) {
    for (int col = 0; col < values.cols; ++col) {
      if (is_known(row, col) != 0) known.push_back(values(row, col));
    }
  }
  if (known.empty()) throw std::runtime_error("ground: nothing of it is known");
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

// Mean of what is known within a coarse cell; `kNowhere` where nothing is. One more disc of nothing
// on every side.
cv::Mat1f Coarse(const RealGround& place, int margin) {
  const double scale = place.cell_size_m / kBareCellM;
  cv::Mat1f share, sum;
  const cv::Mat1f weight = cv::Mat1f(place.is_known) / 255.0f;
  cv::resize(weight, share, {}, scale, scale, cv::INTER_AREA);
  cv::resize(place.surface.mul(weight), sum, share.size(), 0.0, 0.0, cv::INTER_AREA);
  cv::Mat1f mean = sum / share;
  mean.setTo(kNowhere, share < 0.5f);
  cv::copyMakeBorder(
      mean, mean, margin, margin, margin, margin, cv::BORDER_CONSTANT, cv::Scalar(kNowhere));
  return mean;
}

// What a disc touches that is pressed onto the surface from below: an opening.
cv::Mat1f GroundBelow(const RealGround& place, double widest_thing_m) {
  const int margin = static_cast<int>(0.5 * widest_thing_m / kBareCellM);
  const int side = 2 * margin + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side});
  cv::Mat1f low = Coarse(place, margin);
  const cv::Size size(low.cols - 2 * margin, low.rows - 2 * margin);
  cv::erode(low, low, disc);
  low.setTo(-kNowhere, low >= kNowhere);
  cv::dilate(low, low, disc);
  low.setTo(0.0f, low <= -kNowhere);
  cv::GaussianBlur(low, low, {}, 1.0);
  cv::Mat1f ground;
  cv::resize(low(cv::Rect({margin, margin}, size)), ground, place.surface.size());
  return cv::min(ground, place.surface);
}

cv::Mat1f BareGround(const RealGround& place) {
  cv::Mat1f ground = GroundBelow(place, kWidestCrownM);
  const cv::Mat1f below_roofs = GroundBelow(place, kWidestRoofM);
  below_roofs.copyTo(ground, place.surface - below_roofs > kTallM);
  return ground;
}

Cover CoverNamed(const std::string& name) {
  for (int cover = 0; cover < kNumCovers; ++cover) {
    if (name == CoverName(static_cast<Cover>(cover))) return static_cast<Cover>(cover);
  }
  throw std::runtime_error("ground: no cover is named " + name);
}

// Later outlines lie over earlier ones.
void DrawOutlines(const std::string& path, cv::Mat1b& cover) {
  std::ifstream file = Open(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string name;
    if (!(words >> name) || name[0] == '#') continue;
    std::vector<cv::Point> corners;
    for (cv::Point corner; words >> corner.x >> corner.y;) corners.push_back(corner);
    if (corners.size() < 3 || !words.eof())
      throw std::runtime_error(path + ": no outline: " + line);
    cv::fillPoly(cover, std::vector{corners}, static_cast<int>(CoverNamed(name)));
  }
}

cv::Mat1b CoverOf(const RealGround& place, const std::string& outlines) {
  const cv::Mat1f height = place.surface - place.ground;
  cv::Mat1b cover(height.size(), static_cast<uint8_t>(Cover::kScrub));
  cover.setTo(static_cast<int>(Cover::kTree), height > kTallM);
  DrawOutlines(outlines, cover);
  cover.setTo(static_cast<int>(Cover::kScrub),
              (cover == static_cast<int>(Cover::kMeadow)) & (height > kTallestGrassM));
  return cover;
}

}  // namespace

RealGround ReadRealGround(const std::string& pack) {
  const std::string stem = FolderOf(pack) + "/" + pack;
  RealGround place;
  place.cell_size_m = nlohmann::json::parse(Open(stem + ".json")).at("gsd_m").get<double>();
  const cv::Mat photograph = ReadRaster(stem + "_ortho.tif", CV_8UC4);
  place.surface = ReadRaster(stem + "_dsm.tif", CV_32FC1);
  if (photograph.size() != place.surface.size()) {
    throw std::runtime_error(stem + ": photograph and surface model differ in size");
  }
  cv::Mat1b alpha;
  cv::extractChannel(photograph, alpha, 3);
  cv::cvtColor(photograph, place.photograph, cv::COLOR_BGRA2BGR);
  // Without its outermost pixels, so that whoever interpolates does so between known ones.
  cv::erode((alpha > 0) & (place.surface > kUnknownHeight),
            place.is_known,
            cv::Mat1b::ones(3, 3),
            {-1, -1},
            1,
            cv::BORDER_CONSTANT,
            cv::Scalar(0));
  place.datum_m = MedianOf(place.surface, place.is_known);
  place.surface -= static_cast<float>(place.datum_m);
  place.ground = BareGround(place);
  place.cover = CoverOf(place, FREELSD_SOURCE_DIR "/tests/synthetic/ground/" + pack + ".txt");
  return place;
}

}  // namespace freelsd
