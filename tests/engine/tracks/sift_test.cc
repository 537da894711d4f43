#include "engine/tracks/sift.h"

#include <doctest/doctest.h>
#include <opencv2/features2d.hpp>

#include "tests/engine/tracks/textured_plane.h"

namespace freelsd {
namespace {

constexpr float kContrast = 0.005F;
constexpr double kMaxPlaceErrorPx = 0.01;
// OpenCV rounds otherwise on the way, and differently on every processor.
constexpr double kMaxEntryError = 1.5;
constexpr double kMinShareFound = 0.98;

cv::Mat1b Photograph(cv::Size size, unsigned seed) {
  Camera camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  camera.fx_px = camera.fy_px = size.width;
  camera.cx_px = 0.5 * size.width;
  camera.cy_px = 0.5 * size.height;
  // Looks straight down.
  const Rigid3d world_from_camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(CV_PI, Eigen::Vector3d::UnitX())), {0.0, 0.0, 100.0}};
  return TexturedPlane(120.0, seed).Photograph(camera, world_from_camera);
}

struct Keypoints {
  std::vector<cv::Point2f> places;
  cv::Mat1f descriptors;
};

Keypoints Ours(const cv::Mat1b& grey) {
  const std::vector<Octave> octaves = ScaleSpaceOf(grey, kMinOctaveSidePx);
  Keypoints keypoints;
  for (const Blob& blob : FindBlobs(octaves, kContrast)) {
    for (const float direction_deg : DirectionsOf(blob, octaves)) {
      const Descriptor descriptor = Describe(blob, direction_deg, octaves);
      const cv::Mat1b row(1, kNumDescriptorEntries, const_cast<uint8_t*>(descriptor.data()));
      keypoints.places.push_back(blob.PlaceInImage());
      keypoints.descriptors.push_back(cv::Mat1f(row));
    }
  }
  return keypoints;
}

Keypoints OfOpenCv(const cv::Mat1b& grey) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(
      0, kNumScalesPerOctave, kContrast * kNumScalesPerOctave, 10.0, kFirstSigmaPx);
  std::vector<cv::KeyPoint> found;
  Keypoints keypoints;
  sift->detectAndCompute(grey, cv::noArray(), found, keypoints.descriptors);
  for (const cv::KeyPoint& keypoint : found) keypoints.places.push_back(keypoint.pt);
  return keypoints;
}

// Share of the keypoints of `wanted` that `found` has too, with the same descriptor.
double ShareFound(const Keypoints& wanted, const Keypoints& found) {
  int num_found = 0;
  for (size_t i = 0; i < wanted.places.size(); ++i) {
    for (size_t j = 0; j < found.places.size(); ++j) {
      if (cv::norm(wanted.places[i] - found.places[j]) > kMaxPlaceErrorPx) continue;
      const double difference = cv::norm(wanted.descriptors.row(static_cast<int>(i)),
                                         found.descriptors.row(static_cast<int>(j)),
                                         cv::NORM_INF);
      if (difference > kMaxEntryError) continue;
      ++num_found;
      break;
    }
  }
  return static_cast<double>(num_found) / static_cast<double>(wanted.places.size());
}

TEST_CASE("sift: keypoints and descriptors are those of OpenCV, but for rounding") {
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(241, 163), cv::Size(64, 200)}) {
    CAPTURE(size.width);
    const cv::Mat1b grey = Photograph(size, static_cast<unsigned>(size.width));
    const Keypoints ours = Ours(grey), theirs = OfOpenCv(grey);
    REQUIRE(theirs.places.size() > 100);
    CHECK(ShareFound(theirs, ours) > kMinShareFound);
    CHECK(ShareFound(ours, theirs) > kMinShareFound);
  }
}

TEST_CASE("sift: the strongest blobs come first") {
  const std::vector<Octave> octaves = ScaleSpaceOf(Photograph({200, 150}, 3), kMinOctaveSidePx);
  const std::vector<Blob> blobs = FindBlobs(octaves, kContrast);
  REQUIRE(blobs.size() > 10);
  for (size_t i = 1; i < blobs.size(); ++i) CHECK(blobs[i].contrast <= blobs[i - 1].contrast);
  CHECK(blobs.back().contrast >= kContrast);
}

TEST_CASE("sift: an even image has no blobs, and neither has one that is too small") {
  for (const cv::Size size : {cv::Size(80, 60), cv::Size(5, 5), cv::Size(1, 1), cv::Size(300, 2)}) {
    CAPTURE(size.width);
    const cv::Mat1b even(size, uint8_t{90});
    CHECK(FindBlobs(ScaleSpaceOf(even, kMinOctaveSidePx), kContrast).empty());
  }
}

TEST_CASE("sift: at the border of an image descriptors look at what there is") {
  const cv::Mat1b grey = Photograph({44, 40}, 5);
  const Keypoints ours = Ours(grey), theirs = OfOpenCv(grey);
  REQUIRE(!theirs.places.empty());
  CHECK(ShareFound(theirs, ours) == 1.0);
}

}  // namespace
}  // namespace freelsd
