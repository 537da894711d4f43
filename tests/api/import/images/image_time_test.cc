// When a photograph was taken, by its tags.
#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/import/date_time.h"
#include "api/import/images/images.h"
#include "api/stored/stored.h"
#include "tests/api/import/images/tagged_image.h"

namespace freelsd {
namespace {

constexpr char kTaken[] = "2024:06:01 14:00:00";
const int64_t kTakenUs = *TimestampFromText(kTaken);
constexpr int64_t kHourUs = int64_t{3600} * 1000000;

std::string PlainJpeg() {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(80, 90, 100)), bytes);
  return {bytes.begin(), bytes.end()};
}

ImageTags Read(const std::string& bytes) {
  return ReadImageTags(bytes, SniffImage(bytes, ImageLimits{}));
}

FrameMeta MetaWith(const PhotoTimes& times, const std::string& xmp = "") {
  const std::string jpeg = WithGeotag(PlainJpeg(), {}, times);
  return Read(xmp.empty() ? jpeg : WithXmpTags(jpeg, xmp)).meta;
}

TEST_CASE("photographs without a usable date: the receiver's time and OffsetTime come first") {
  const FrameMeta local = MetaWith({kTaken, "", "", {}});
  CHECK(local.timestamp_us == kTakenUs);
  CHECK(local.time_source == TimeSource::kCameraLocal);
  const FrameMeta offset = MetaWith({kTaken, "+02:00", "", {}});
  CHECK(offset.timestamp_us == kTakenUs - 2 * kHourUs);
  CHECK(offset.time_source == TimeSource::kCamera);
  const FrameMeta gps = MetaWith({kTaken, "+05:00", "2024:06:01", {12, 0, 1}});
  // The camera's clock tells the moment, the receiver its offset from UTC.
  CHECK(gps.timestamp_us == kTakenUs - 2 * kHourUs);
  CHECK(gps.time_source == TimeSource::kGps);
  // A clock that is minutes off tells nothing.
  const FrameMeta drifted = MetaWith({kTaken, "", "2024:06:01", {12, 4, 0}});
  CHECK(drifted.timestamp_us == kTakenUs - 2 * kHourUs + 240000000);
  CHECK(MetaWith({"", "", "2024:06:01", {14, 0, 0}}).timestamp_us == kTakenUs);
  for (const char* const xmp : {"drone-dji:UTCAtExposure='2024-06-01T12:00:00.500'",
                                "exif:GPSTimeStamp='2024-06-01T12:00:01Z'"}) {
    CHECK(MetaWith({kTaken, "", "", {}}, xmp).timestamp_us == kTakenUs - 2 * kHourUs);
  }
  const FrameMeta xmp =
      MetaWith({kTaken, "", "", {}}, "xmp:CreateDate='2024-06-01T14:00:00+02:00'");
  CHECK(xmp.timestamp_us == kTakenUs - 2 * kHourUs);
  CHECK(xmp.time_source == TimeSource::kCamera);
}

TEST_CASE(
    "photographs without a usable date: zeros and a receiver that was never set are no time") {
  CHECK_FALSE(MetaWith({"0000:00:00 00:00:00", "", "0000:00:00", {0, 0, 0}}).timestamp_us);
  const FrameMeta unset = MetaWith({kTaken, "", "1980:01:06", {0, 0, 10}});
  CHECK(unset.timestamp_us == kTakenUs);
  CHECK(unset.time_source == TimeSource::kCameraLocal);
  CHECK(MetaWith({kTaken, "", "2024:06:01", {12, 0}}).time_source == TimeSource::kCameraLocal);
}

TEST_CASE("photographs without a usable date: a camera's clock one year behind is warned of") {
  const ImageTags tags =
      Read(WithGeotag(PlainJpeg(), {}, {"2023:06:02 12:00:00", "", "2024:06:01", {12, 0, 0}}));
  CHECK(tags.meta.timestamp_us == kTakenUs - 2 * kHourUs);
  REQUIRE_FALSE(tags.warnings.empty());
  CHECK(tags.warnings.back().starts_with(
      "the camera's clock is 365 days behind the receiver's time"));
}

TEST_CASE("photographs without a usable date: the source of a time is stored, and merged with it") {
  const FrameMeta gps = MetaWith({kTaken, "", "2024:06:01", {12, 0, 0}});
  CHECK(ParseStoredFrameMeta(FrameMetaJson(gps)).time_source == TimeSource::kGps);
  FrameMeta given;
  CHECK(Merged(given, gps).time_source == TimeSource::kGps);
  given.timestamp_us = 5;
  CHECK(Merged(given, gps).time_source == TimeSource::kGiven);
  // The meta of clients is compared as text.
  CHECK(FrameMetaJson(given) == "{\"timestamp_us\":5}");
}

}  // namespace
}  // namespace freelsd
