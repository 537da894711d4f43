#include "server/intake/odd_photographs.h"

#include <doctest/doctest.h>

#include "api/import/gimbal.h"

namespace freelsd {
namespace {

constexpr int64_t kSecondUs = 1000000;
constexpr int64_t kStartUs = 1717236000 * kSecondUs;
constexpr double kDegPerKilometre = 1.0 / 111.2;

// One photograph each two seconds, 20 m further north, 100 m above the ground.
std::vector<BatchPhoto> Flight(int num_photos) {
  std::vector<BatchPhoto> photos;
  for (int i = 0; i < num_photos; ++i) {
    BatchPhoto photo;
    photo.image.id = std::to_string(i) + ".jpg";
    CheckedImage image;
    image.header = {true, 4000, 3000};
    image.tags.camera_name = "DJI M3E";
    Camera camera;
    camera.width_px = 4000;
    camera.height_px = 3000;
    camera.fx_px = camera.fy_px = 2900.0;
    image.tags.camera = camera;
    photo.image.image = image;
    photo.tags.position = GeoPoint{47.35 + i * 0.02 * kDegPerKilometre, 8.45, 555.0};
    photo.tags.timestamp_us = kStartUs + 2 * i * kSecondUs;
    photo.tags.height_above_ground_m = 100.0;
    photo.tags.ned_from_camera = NedFromGimbalCamera({0.0, RadFromDeg(-90.0), RadFromDeg(20.0)});
    photo.meta = photo.tags;
    photos.push_back(photo);
  }
  return photos;
}

// `change` applies to the tags.
template <typename Change>
std::vector<BatchPhoto> With(std::vector<BatchPhoto> photos,
                             const std::vector<size_t>& which,
                             const Change& change) {
  for (const size_t i : which) {
    change(photos[i].tags, *photos[i].image.image);
    photos[i].meta = photos[i].tags;
  }
  return photos;
}

// Numbers of the photographs that are left out.
std::string LeftOut(const std::vector<BatchPhoto>& photos) {
  std::string numbers;
  const ComparedPhotos compared = ComparePhotos(photos, {});
  for (size_t i = 0; i < compared.photos.size(); ++i) {
    if (!compared.photos[i].image.reason.empty()) numbers += std::to_string(i);
  }
  // Each is named.
  CHECK(numbers.empty() == compared.warnings.empty());
  return numbers;
}

bool Tells(const ComparedPhotos& compared, const std::string& words) {
  for (const std::string& warning : compared.warnings) {
    if (warning.find(words) != std::string::npos) return true;
  }
  return false;
}

auto North(double kilometres) {
  return [kilometres](FrameMeta& tags, CheckedImage&) {
    tags.position->latitude_deg += kilometres * kDegPerKilometre;
  };
}

auto At(double altitude_m) {
  return [altitude_m](FrameMeta& tags, CheckedImage&) {
    tags.position->altitude_m = altitude_m;
    tags.height_above_ground_m.reset();
  };
}

void Untimed(FrameMeta& tags, CheckedImage& /*image*/) { tags.timestamp_us.reset(); }

TEST_CASE("odd photographs: a wrong fix is left out, wherever it comes") {
  const std::vector<size_t> all{0, 1, 2, 3, 4, 5, 6, 7};
  CHECK(LeftOut(Flight(8)).empty());
  CHECK(LeftOut(With(Flight(8), {0}, North(83.0))) == "0");
  CHECK(LeftOut(With(Flight(8), {0}, North(2.0))) == "0");
  CHECK(LeftOut(With(Flight(8), {4}, North(-2.0))) == "4");
  CHECK(LeftOut(With(Flight(8), {7}, North(1.0))) == "7");
  CHECK(LeftOut(With(Flight(8), {0, 1, 2}, North(83.0))) == "012");
  CHECK(LeftOut(With(Flight(8), {0, 5}, North(83.0))) == "05");
  CHECK(LeftOut(With(With(Flight(8), all, Untimed), {0}, North(2.0))) == "0");
  CHECK(LeftOut(With(With(Flight(8), all, Untimed), {0, 1}, North(83.0))) == "01");
  CHECK(LeftOut(With(Flight(3), {1}, North(83.0))) == "1");
}

TEST_CASE("odd photographs: an altitude that no aircraft climbs to is left out") {
  CHECK(LeftOut(With(Flight(8), {3}, At(0.0))) == "3");
  CHECK(LeftOut(With(Flight(8), {0}, At(6553.0))) == "0");
  CHECK(LeftOut(With(Flight(8), {7}, At(-555.0))) == "7");
  CHECK(LeftOut(With(Flight(8), {3}, At(600.0))).empty());
}

TEST_CASE("odd photographs: a flight of two places, and two photographs, are kept") {
  // A photograph at the place of launch, ten minutes before.
  const auto launch = With(Flight(8), {0}, [](FrameMeta& tags, CheckedImage&) {
    tags.position->latitude_deg += 2.0 * kDegPerKilometre;
    tags.timestamp_us = kStartUs - 600 * kSecondUs;
  });
  CHECK(LeftOut(launch).empty());
  CHECK(LeftOut(With(Flight(2), {0}, North(83.0))).empty());
  const ComparedPhotos halves = ComparePhotos(With(Flight(8), {0, 1, 2, 3}, North(83.0)), {});
  CHECK(halves.photos[0].image.reason.empty());
  CHECK(halves.photos[7].image.reason.empty());
  CHECK(Tells(halves, "yet it is used"));
}

auto Lens(int width_px, int height_px, double focal_px, const std::string& name) {
  return [=](FrameMeta&, CheckedImage& image) {
    image.header.width_px = width_px;
    image.header.height_px = height_px;
    image.tags.camera_name = name;
    image.tags.camera->width_px = width_px;
    image.tags.camera->height_px = height_px;
    image.tags.camera->fx_px = image.tags.camera->fy_px = focal_px;
  };
}

TEST_CASE("odd photographs: of several cameras the one that shows most is used") {
  // Thermal before wide, of the same seconds.
  CHECK(LeftOut(With(Flight(8), {0, 2, 4, 6}, Lens(640, 512, 1000.0, "DJI M3E"))) == "0246");
  // A zoom beside it, with as many pixels; another zoom of the same camera in between.
  CHECK(LeftOut(With(Flight(8), {0, 2, 4, 6}, Lens(4000, 3000, 13000.0, "DJI M3E"))) == "0246");
  CHECK(LeftOut(With(Flight(8), {3}, Lens(4000, 3000, 3300.0, "DJI M3E"))) == "3");
  // A telephone's picture of the launch, larger than the others.
  CHECK(LeftOut(With(Flight(8), {0}, Lens(8000, 6000, 5800.0, "Apple iPhone"))) == "0");
  CHECK(LeftOut(With(Flight(8), {7}, Lens(3000, 4000, 2900.0, "DJI M3E"))) == "7");
  CHECK(LeftOut(With(Flight(8), {0}, Lens(4000, 3000, 2910.0, "DJI M3E"))).empty());
  const auto thermal = With(Flight(8), {0}, Lens(640, 512, 1000.0, "DJI M3T"));
  CHECK(Tells(ComparePhotos(thermal, {}), "1 photograph left out: of another camera (DJI M3T"));
  PhotoRules rules;
  rules.has_camera = true;
  CHECK(ComparePhotos(thermal, rules).warnings.empty());
}

TEST_CASE("odd photographs: a height that does not fit the take-off of the others is not used") {
  const ComparedPhotos compared =
      ComparePhotos(With(Flight(8),
                         {2},
                         [](FrameMeta& tags, CheckedImage&) { tags.height_above_ground_m = 1000; }),
                    {});
  CHECK_FALSE(compared.photos[2].tags.height_above_ground_m);
  CHECK(compared.photos[3].tags.height_above_ground_m == 100.0);
  CHECK(Tells(compared, "2.jpg: its height above take-off"));
}

auto Gimbal(double pitch_deg) {
  return [pitch_deg](FrameMeta& tags, CheckedImage&) {
    tags.ned_from_camera = NedFromGimbalCamera({0.0, RadFromDeg(pitch_deg), 0.3});
  };
}

auto Aircraft(double roll_deg, double pitch_deg) {
  return [=](FrameMeta& tags, CheckedImage&) {
    tags.ned_from_camera.reset();
    tags.ned_from_body = NedFromBody({RadFromDeg(roll_deg), RadFromDeg(pitch_deg), 0.3});
  };
}

TEST_CASE("odd photographs: angles of another convention are read or not used, and told") {
  const std::vector<size_t> all{0, 1, 2, 3, 4, 5};
  const auto number_with_angles = [](const ComparedPhotos& compared) {
    size_t number = 0;
    for (const BatchPhoto& photo : compared.photos) {
      number += photo.tags.ned_from_camera || photo.tags.ned_from_body ? 1 : 0;
    }
    return number;
  };
  for (const auto& photos : {With(Flight(6), all, Gimbal(0.0)),
                             With(Flight(6), all, Gimbal(30.0)),
                             With(Flight(6), all, Aircraft(90.0, 0.0)),
                             With(Flight(6), all, Aircraft(0.0, 90.0)),
                             With(Flight(6), all, Aircraft(180.0, 0.0))}) {
    const ComparedPhotos compared = ComparePhotos(photos, {});
    CHECK(number_with_angles(compared) == 0);
    CHECK(Tells(compared, "angles=given"));
    PhotoRules given;
    given.angles = BatchAngles::kGiven;
    CHECK(number_with_angles(ComparePhotos(photos, given)) == 6);
  }
  const ComparedPhotos dives = ComparePhotos(With(Flight(6), all, Aircraft(0.0, -90.0)), {});
  for (const BatchPhoto& photo : dives.photos) {
    REQUIRE(photo.tags.ned_from_camera);
    CHECK((*photo.tags.ned_from_camera * Eigen::Vector3d::UnitZ()).z() > 0.999);
  }
  CHECK(Tells(dives, "pitch near -90"));
  // Some look at the horizon, and oblique cameras, are as they should be.
  for (const auto& photos : {With(Flight(6), {0, 1}, Gimbal(0.0)),
                             With(Flight(6), all, Gimbal(-45.0)),
                             With(Flight(6), all, Aircraft(10.0, 5.0))}) {
    const ComparedPhotos compared = ComparePhotos(photos, {});
    CHECK(number_with_angles(compared) == 6);
    CHECK(compared.warnings.empty());
  }
  PhotoRules none;
  none.angles = BatchAngles::kNone;
  CHECK(number_with_angles(ComparePhotos(Flight(6), none)) == 0);
}

}  // namespace
}  // namespace freelsd
