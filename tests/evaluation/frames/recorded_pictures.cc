#include "tests/evaluation/frames/recorded_pictures.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "server/training/labelled_photographs.h"
#include "tests/evaluation/places/place_cameras.h"
#include "tests/evaluation/places/place_labels.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {
namespace {

constexpr const char* kFolder = FREELSD_SOURCE_DIR "/tests/evaluation/";
// From 5 to 30 m above ground, and at 0.3 m per pixel.
constexpr std::array<const char*, 2> kPlacesOfOtherScale{"semantic_drone", "loveda_mmseg"};
// Photographed in November: its trees have no leaves.
constexpr const char* kLeaflessPlace = "garfield_park";

std::string DataFolder() {
  const char* data = std::getenv("FREELSD_DATA");
  if (data == nullptr) throw std::runtime_error("frames: FREELSD_DATA is not set");
  return data;
}

// Cover of a class of $FREELSD_DATA/grass. Its soil is soil, gravel, pebbles and mud.
Cover CoverOfMask(int surface_class, const std::string& place) {
  switch (surface_class) {
    case kGrassClass:
      return Cover::kMeadow;
    case 2:
      return place == kLeaflessPlace ? Cover::kBareTree : Cover::kTree;
    case 3:
      return Cover::kScrub;
    case 5:
      return Cover::kSoil;
    case 6:
      return Cover::kRoad;
    case 8:
      return Cover::kWater;
    default:
      return Cover::kDoubt;  // crops and stubble are one class
  }
}

Cover CoverOfPolygon(PlaceClass surface) {
  switch (surface) {
    case PlaceClass::kGrass:
      return Cover::kMeadow;
    case PlaceClass::kRoughGrass:
      return Cover::kScrub;
    case PlaceClass::kCrop:
      return Cover::kCrop;
    case PlaceClass::kStubble:
      return Cover::kStubble;
    case PlaceClass::kSoil:
      return Cover::kSoil;
    case PlaceClass::kTree:
      return Cover::kTree;
    case PlaceClass::kWater:
      return Cover::kWater;
    case PlaceClass::kPaved:
      return Cover::kRoad;
    default:
      return Cover::kDoubt;  // single bushes and buildings
  }
}

LabelledPicture PictureOf(const LabelledPhotograph& photograph) {
  LabelledPicture picture;
  picture.name = photograph.name;
  picture.look = kRecorded;
  picture.image = photograph.image;
  picture.ground_sampling_m = photograph.height_above_ground / photograph.camera.MeanFocalPx();
  cv::Mat1b table(1, 256, static_cast<uint8_t>(Cover::kDoubt));
  for (int i = 0; i < kNumClasses; ++i) {
    table(i) = static_cast<uint8_t>(CoverOfMask(i, photograph.place));
  }
  cv::LUT(photograph.mask, table, picture.cover);
  return picture;
}

std::vector<LabelledPicture> ReadTuningPictures(double ground_sampling_m, PoolOfRun& run) {
  std::vector<LabelledPicture> pictures;
  for (const LabelledPhotograph& photograph :
       ReadLabelledPhotographs(DataFolder() + "/grass",
                               ReadLabelledCameras(std::string(kFolder) + "grass_cameras.csv"))) {
    run.Add("flight " + photograph.place, EvaluationPools().Of("flight", photograph.place));
    const auto picture = AtScale(PictureOf(photograph), ground_sampling_m);
    if (picture) pictures.push_back(*picture);
  }
  return pictures;
}

cv::Mat3b ReadPlacePhotograph(const std::string& place, const std::string& photograph) {
  const std::string stem = DataFolder() + "/places/" + place + "/" + photograph;
  for (const std::string& extension : kPhotographExtensions) {
    if (!std::filesystem::exists(stem + extension)) continue;
    return cv::imread(stem + extension, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  }
  throw std::runtime_error("frames: no photograph " + stem);
}

void Fill(cv::Mat1b& cover, const PlacePolygon& polygon) {
  std::vector<cv::Point> outline;
  outline.reserve(polygon.outline_in_image.size());
  for (const cv::Point2d& vertex : polygon.outline_in_image) outline.emplace_back(vertex);
  cv::fillPoly(cover,
               std::vector<std::vector<cv::Point>>{outline},
               static_cast<uint8_t>(CoverOfPolygon(polygon.surface)));
}

std::vector<LabelledPicture> ReadPlace(const std::string& place, double ground_sampling_m) {
  const std::string folder = std::string(kFolder) + "places/";
  const std::vector<PlaceCamera> cameras = ReadPlaceCameras(folder + "cameras.csv");
  std::map<std::string, std::vector<PlacePolygon>> polygons_of_photograph;
  for (PlacePolygon& polygon : ReadPlacePolygons(folder + "labels/" + place + ".txt")) {
    polygons_of_photograph[polygon.photograph].push_back(std::move(polygon));
  }
  std::vector<LabelledPicture> pictures;
  for (const auto& [photograph, polygons] : polygons_of_photograph) {
    LabelledPicture picture;
    picture.name = place + "__" + photograph;
    picture.look = kRecorded;
    picture.image = ReadPlacePhotograph(place, photograph);
    picture.cover = cv::Mat1b(picture.image.size(), static_cast<uint8_t>(Cover::kDoubt));
    for (const PlacePolygon& polygon : polygons) Fill(picture.cover, polygon);
    picture.ground_sampling_m = CameraOf(place, photograph, cameras).ground_sampling_m;
    const auto scaled = AtScale(picture, ground_sampling_m);
    if (scaled) pictures.push_back(*scaled);
  }
  return pictures;
}

std::vector<LabelledPicture> ReadReportPictures(double ground_sampling_m, PoolOfRun& run) {
  std::vector<LabelledPicture> pictures;
  for (const std::string& place : EvaluationPools().NamesOf("place", Pool::kReport)) {
    if (std::find(kPlacesOfOtherScale.begin(), kPlacesOfOtherScale.end(), place) !=
        kPlacesOfOtherScale.end()) {
      continue;
    }
    run.Add("place " + place, EvaluationPools().Of("place", place));
    for (LabelledPicture& picture : ReadPlace(place, ground_sampling_m)) {
      pictures.push_back(std::move(picture));
    }
  }
  return pictures;
}

}  // namespace

std::vector<LabelledPicture> ReadRecordedPictures(Pool pool,
                                                  double ground_sampling_m,
                                                  PoolOfRun& run) {
  return pool == Pool::kTuning ? ReadTuningPictures(ground_sampling_m, run)
                               : ReadReportPictures(ground_sampling_m, run);
}

}  // namespace freelsd
