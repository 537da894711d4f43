#include <thread>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>

#include "api/import/date_time.h"
#include "api/import/gimbal.h"
#include "api/import/images/image_segments.h"
#include "api/import/images/images.h"
#include "api/import/images/tag_source.h"
#include "api/import/number_text.h"
#include "api/stored/stored.h"
#include "tests/api/flights.h"
#include "tests/api/import/images/tagged_image.h"

namespace freelsd {
namespace {

constexpr double kMaxPositionErrorDeg = 1e-9;
constexpr double kMaxAltitudeErrorM = 0.01;
constexpr double kMaxRotationErrorRad = 1e-9;
constexpr double kMaxFocalErrorPx = 0.1;
// GPSAltitude has millimetres, the tables have metres to two or three decimals.

std::string PlainJpeg(int width, int height) {
  std::vector<uchar> bytes;
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, cv::Scalar(80, 90, 100)), bytes);
  return {bytes.begin(), bytes.end()};
}

std::string WithXmp(const std::string& attributes) {
  return WithXmpTags(PlainJpeg(64, 48), attributes);
}

ImageTags Read(const std::string& bytes) {
  return ReadImageTags(bytes, SniffImage(bytes, ImageLimits{}));
}

EulerAngles Radians(double roll_deg, double pitch_deg, double yaw_deg) {
  return {RadFromDeg(roll_deg), RadFromDeg(pitch_deg), RadFromDeg(yaw_deg)};
}

TEST_CASE("tags: a plain image has none, and says that the camera is unknown") {
  const ImageTags tags = Read(PlainJpeg(64, 48));
  CHECK(FrameMetaJson(tags.meta) == "{}");
  CHECK_FALSE(tags.camera);
  CHECK(tags.warnings.size() == 1);
}

TEST_CASE("tags: DJI with a t too many, signs in text") {
  const ImageTags tags =
      Read(WithXmp("drone-dji:GpsLatitude='+46.5' drone-dji:GpsLongtitude='-91.25' "
                   "drone-dji:AbsoluteAltitude='+121.6' drone-dji:RelativeAltitude='+40.10' "
                   "drone-dji:GimbalYawDegree='+90.0' drone-dji:GimbalPitchDegree='-90.0' "
                   "drone-dji:GimbalRollDegree='+0.0'"));
  REQUIRE(tags.meta.position);
  CHECK(tags.meta.position->latitude_deg == 46.5);
  CHECK(tags.meta.position->longitude_deg == -91.25);
  CHECK(tags.meta.position->altitude_m == 121.6);
  CHECK(tags.meta.height_above_ground_m == 40.1);
  REQUIRE(tags.meta.ned_from_camera);
  CHECK(AngleBetween(*tags.meta.ned_from_camera, NedFromGimbalCamera(Radians(0, -90, 90))) <
        kMaxRotationErrorRad);
}

TEST_CASE("tags: Parrot, the camera's angles are those of a gimbal") {
  const auto attitude = [](const std::string& pitch, const std::string& yaw) {
    const ImageTags tags =
        Read(WithXmp("drone-parrot:CameraRollDegree='+0.00' "
                     "drone-parrot:CameraPitchDegree='" +
                     pitch + "' drone-parrot:CameraYawDegree='" + yaw + "'"));
    CHECK_FALSE(tags.meta.ned_from_body);
    REQUIRE(tags.meta.ned_from_camera);
    return *tags.meta.ned_from_camera;
  };
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d top = -Eigen::Vector3d::UnitY();
  // Straight down, the image's top east.
  const Eigen::Quaterniond down = attitude("-90.00", "+90.00");
  CHECK((down * axis - Eigen::Vector3d(0, 0, 1)).norm() < kMaxRotationErrorRad);
  CHECK((down * top - Eigen::Vector3d(0, 1, 0)).norm() < kMaxRotationErrorRad);
  // Level to the west, the image's top up.
  const Eigen::Quaterniond level = attitude("+0.00", "-90.00");
  CHECK((level * axis - Eigen::Vector3d(0, -1, 0)).norm() < kMaxRotationErrorRad);
  CHECK((level * top - Eigen::Vector3d(0, 0, -1)).norm() < kMaxRotationErrorRad);
  // 60 deg down and north: cos 60 and sin 60.
  CHECK((attitude("-60", "0") * axis - Eigen::Vector3d(0.5, 0, 0.8660254038)).norm() <
        kMaxRotationErrorRad);
}

TEST_CASE("tags: senseFly and its like, the aircraft's angles, level is 0, 0") {
  const ImageTags tags = Read(WithXmp("Camera:Yaw='90' Camera:Pitch='10' Camera:Roll='0'"));
  CHECK_FALSE(tags.meta.ned_from_camera);
  CHECK(tags.meta.attitude_sd_deg == 5.0);
  REQUIRE(tags.meta.ned_from_body);
  // East, the nose 10 deg up, the right wing south.
  const Eigen::Quaterniond& climbing = *tags.meta.ned_from_body;
  CHECK((climbing * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0, 0.9848077530, -0.1736481777))
            .norm() < kMaxRotationErrorRad);
  CHECK((climbing * Eigen::Vector3d::UnitY() - Eigen::Vector3d(-1, 0, 0)).norm() <
        kMaxRotationErrorRad);
  // North, the right wing 30 deg down.
  const Eigen::Quaterniond banked =
      *Read(WithXmp("Camera:Yaw='0' Camera:Pitch='0' Camera:Roll='30'")).meta.ned_from_body;
  CHECK((banked * Eigen::Vector3d::UnitY() - Eigen::Vector3d(0, 0.8660254038, 0.5)).norm() <
        kMaxRotationErrorRad);
  // The heading alone: level, and not known well.
  const ImageTags heading = Read(WithXmp("Camera:Yaw='-90'"));
  CHECK(heading.meta.attitude_sd_deg == 8.0);
  CHECK(
      (*heading.meta.ned_from_body * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0, -1, 0)).norm() <
      kMaxRotationErrorRad);
}

// Minutes and seconds are used too: 47 deg 30' 36" N, 8 deg 15' 0" W.
std::string InMinutesAndSeconds() {
  std::string jpeg = WithGeotag(PlainJpeg(64, 48), {1.0, -1.0, 123.4, 0});
  const std::string one = LittleEndian(10000000, 4) + LittleEndian(10000000, 4);
  const auto replace = [&jpeg, &one](uint32_t degrees, uint32_t minutes, uint32_t seconds) {
    std::string angle;
    for (const uint32_t number : {degrees, minutes, seconds}) {
      angle += LittleEndian(number, 4) + LittleEndian(1, 4);
    }
    jpeg.replace(jpeg.find(one), angle.size(), angle);
  };
  replace(47, 30, 36);
  replace(8, 15, 0);
  return jpeg;
}

TEST_CASE("tags: altitudes of EXIF are taken as they stand, below the datum with their sign") {
  const ImageTags above = Read(InMinutesAndSeconds());
  REQUIRE(above.meta.position);
  // 47 + 30/60 + 36/3600.
  CHECK(std::abs(above.meta.position->latitude_deg - 47.51) < kMaxPositionErrorDeg);
  CHECK(std::abs(above.meta.position->longitude_deg + 8.25) < kMaxPositionErrorDeg);
  const std::string jpeg = PlainJpeg(64, 48);
  const double signs[] = {1.0, -1.0, 1.0, -1.0};
  for (uint32_t reference = 0; reference < 4; ++reference) {
    const ImageTags tags = Read(WithGeotag(jpeg, {47.0, 8.0, 123.4, reference}));
    REQUIRE(tags.meta.position);
    CHECK(tags.meta.position->altitude_m == signs[reference] * 123.4);
    CHECK(tags.meta.altitude_datum == "amsl");
  }
}

TEST_CASE("tags: sea level in EXIF is no sea level where a tag of XMP says otherwise") {
  const auto datum_with = [](const std::string& attributes) {
    return Read(WithXmpTags(WithGeotag(PlainJpeg(64, 48), {}), attributes))
        .meta.altitude_datum.value_or("none");
  };
  // DJI: by RTK, by RTK in an older firmware, by barometer; a receiver without a solution; two tags
  // that contradict each other; a type of the future.
  CHECK(datum_with("drone-dji:AltitudeType='RtkAlt' drone-dji:RtkFlag='50'") == "ellipsoid");
  CHECK(datum_with("drone-dji:RtkFlag='16'") == "ellipsoid");
  CHECK(datum_with("drone-dji:AltitudeType='GpsFusionAlt'") == "amsl");
  CHECK(datum_with("drone-dji:AltitudeType='GpsFusionAlt' drone-dji:RtkFlag='0'") == "amsl");
  CHECK(datum_with("drone-dji:RtkFlag='0'") == "none");
  CHECK(datum_with("drone-dji:AltitudeType='GpsFusionAlt' drone-dji:RtkFlag='50'") == "none");
  CHECK(datum_with("drone-dji:AltitudeType='LaserAlt'") == "none");
  // Pix4D's tag of Sequoia, MicaSense and senseFly.
  CHECK(datum_with("Camera:VertCS='ellipsoidal'") == "ellipsoid");
  CHECK(datum_with("Camera:VertCS='EGM96 Geoid'") == "amsl");
  CHECK(datum_with("Camera:VertCS='arbitrary'") == "none");
  CHECK(datum_with("drone-dji:RelativeAltitude='+40.0'") == "amsl");
}

TEST_CASE("tags: an altitude without a reference tells no datum") {
  const ImageTags tags =
      Read(WithXmp("drone-dji:GpsLatitude='46.5' drone-dji:GpsLongitude='8' "
                   "drone-dji:AbsoluteAltitude='+121.6'"));
  REQUIRE(tags.meta.position);
  CHECK_FALSE(tags.meta.altitude_datum);
}

TEST_CASE("tags: zeros, nonsense and out of range are no position") {
  for (const char* const place : {"drone-dji:GpsLatitude='0' drone-dji:GpsLongitude='0' ",
                                  "drone-dji:GpsLatitude='95' drone-dji:GpsLongitude='8' ",
                                  "drone-dji:GpsLatitude='nan' drone-dji:GpsLongitude='8' ",
                                  "drone-dji:GpsLatitude='47' "}) {
    CAPTURE(std::string(place));
    const ImageTags tags = Read(WithXmp(std::string(place) + "drone-dji:AbsoluteAltitude='100'"));
    CHECK_FALSE(tags.meta.position);
    CHECK(tags.warnings.size() >= 2);
  }
}

TEST_CASE("tags: hostile XMP and EXIF are absent, not a crash") {
  const std::string header("http://ns.adobe.com/xap/1.0/\0", 29);
  std::string deep;
  for (int i = 0; i < 12000; ++i) deep += "<a:b>";
  const std::string entities = "<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;'>]><x>&b;</x>";
  for (const std::string& packet : {deep, entities, std::string("<x"), std::string("\0<", 2)}) {
    CHECK_NOTHROW(Read(WithSegment(PlainJpeg(64, 48), header + packet)));
  }
  uint32_t state = 7;
  for (int round = 0; round < 200; ++round) {
    std::string exif("Exif\0\0II*\0\x08\0\0\0", 14);
    for (int i = 0; i < 400; ++i) {
      state = state * 1664525u + 1013904223u;
      exif += static_cast<char>(i % 3 == 0 ? state >> 24 : (state >> 24) % 6);
    }
    CHECK_NOTHROW(Read(WithSegment(PlainJpeg(64, 48), exif)));
  }
}

TEST_CASE("tags: brighton_beach, a multirotor with gimbal angles") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const ImageTags tags = Read(ReadBytes(*flights / "brighton_beach/images/DJI_0018.JPG"));
  REQUIRE(tags.meta.position);
  CHECK(std::abs(tags.meta.position->latitude_deg - 46.8426070833333) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->longitude_deg + 91.9945598888889) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->altitude_m - 198.31) < kMaxAltitudeErrorM);
  CHECK(tags.meta.height_above_ground_m == 39.8);
  CHECK(AngleBetween(*tags.meta.ned_from_camera, NedFromGimbalCamera(Radians(0, -89.9, 45))) <
        kMaxRotationErrorRad);
  // 20 mm of 36 mm over 2400 px.
  CHECK(std::abs(tags.camera->fx_px - 1333.33) < kMaxFocalErrorPx);
  CHECK(tags.camera->source == CameraSource::kExif);
  CHECK(tags.meta.timestamp_us == TimestampFromText("2016:06:23 16:31:59"));
  const ImageTags turned = Read(ReadBytes(*flights / "brighton_beach/images/DJI_0024.JPG"));
  CHECK(turned.warnings.size() == tags.warnings.size() + 1);
}

TEST_CASE("tags: garfield_park, a fixed wing with attitude and a calibrated lens") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const ImageTags tags =
      Read(ReadBytes(*flights / "garfield_park/images/IMG_161122_163234_0000_RGB.JPG"));
  REQUIRE(tags.meta.position);
  CHECK(std::abs(tags.meta.position->latitude_deg - 41.4286810555556) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->longitude_deg + 81.6058853888889) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->altitude_m - 347.723) < kMaxAltitudeErrorM);
  CHECK(tags.meta.position_sd_m == 2.301);
  CHECK_FALSE(tags.meta.ned_from_camera);
  CHECK(AngleBetween(*tags.meta.ned_from_body, NedFromBody(Radians(0.0154285, 5.1846, -16.7996))) <
        kMaxRotationErrorRad);
  CHECK(tags.meta.timestamp_us == TimestampFromText("2016:11:22 16:32:34.498032"));
  REQUIRE(tags.camera);
  CHECK(tags.camera->source == CameraSource::kCalibrated);
  // 4.812073 mm at 373.134 px/mm; principal point 3.042001, 2.280612 mm, less half a pixel.
  CHECK(std::abs(tags.camera->fx_px - 1795.55) < kMaxFocalErrorPx);
  CHECK(std::abs(tags.camera->cx_px - 1134.57) < kMaxFocalErrorPx);
  CHECK(std::abs(tags.camera->cy_px - 850.47) < kMaxFocalErrorPx);
  // k1, k2, k3, p1, p2 in the file; k1, k2, p1, p2, k3 here.
  CHECK(tags.camera->coefficients ==
        std::vector<double>{0.178441961, -0.4745818, -0.000900784, -0.000653429, 0.402026402});
}

TEST_CASE("tags: seneca_nir has a place and a track that is no heading") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const ImageTags tags = Read(ReadBytes(*flights / "seneca_nir/images/IMG_0473.jpg"));
  REQUIRE(tags.meta.position);
  CHECK(std::abs(tags.meta.position->latitude_deg - 41.0359350999975) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->longitude_deg + 83.3068092) < kMaxPositionErrorDeg);
  CHECK(std::abs(tags.meta.position->altitude_m - 283.594) < kMaxAltitudeErrorM);
  CHECK_FALSE(tags.meta.ned_from_body);
  CHECK_FALSE(tags.meta.ned_from_camera);
  // 4.3 mm at 500000/61 px per inch.
  CHECK(std::abs(tags.camera->fx_px - 1387.63) < kMaxFocalErrorPx);
}

TEST_CASE("tags: swindale has neither place nor attitude, but a focal length") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const ImageTags tags = Read(ReadBytes(*flights / "swindale/images/IMG_1417.JPG"));
  CHECK_FALSE(tags.meta.position);
  CHECK(std::abs(tags.camera->fx_px - 1387.63) < kMaxFocalErrorPx);
  CHECK(tags.camera->cx_px == 999.5);
  CHECK(tags.meta.timestamp_us == TimestampFromText("2016:06:29 17:49:32"));
}

TEST_CASE("tags: an image resized after exposure keeps its field of view, with a warning") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const std::string photo = ReadBytes(*flights / "swindale/images/IMG_1417.JPG");
  const std::string exif =
      "Exif" + std::string(2, '\0') + std::string(FindMetadata(photo).exif.at(0));
  const ImageTags half = Read(WithSegment(PlainJpeg(1000, 750), exif));
  CHECK(std::abs(half.camera->fx_px - 0.5 * 1387.63) < kMaxFocalErrorPx);
  CHECK(half.warnings.size() == 1);
  const ImageTags cropped = Read(WithSegment(PlainJpeg(1000, 600), exif));
  CHECK(cropped.warnings.size() == 2);
}

TEST_CASE("tags: the same from many threads at once") {
  const auto flights = FlightsFolder();
  if (!flights) return;
  const std::string bytes = ReadBytes(*flights / "brighton_beach/images/DJI_0018.JPG");
  const std::string expected = FrameMetaJson(Read(bytes).meta);
  std::vector<std::string> answers(8);
  std::vector<std::thread> threads;
  threads.reserve(answers.size());
  for (std::string& answer : answers) {
    threads.emplace_back([&bytes, &answer] {
      for (int i = 0; i < 10; ++i) answer = FrameMetaJson(Read(bytes).meta);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& answer : answers) CHECK(answer == expected);
}

}  // namespace
}  // namespace freelsd
