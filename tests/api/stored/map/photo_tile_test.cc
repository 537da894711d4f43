#include <random>

#include <doctest/doctest.h>

#include "api/import/images/images.h"
#include "api/stored/map/map.h"

namespace freelsd {
namespace {

cv::Mat4b Picture(bool is_opaque) {
  cv::Mat4b picture(64, 64);
  for (int row = 0; row < 64; ++row) {
    for (int col = 0; col < 64; ++col) {
      const int alpha = is_opaque || col < 40 ? 255 : 4 * row;
      picture(row, col) = {uchar(2 * row), uchar(120 + col), uchar(60), uchar(alpha)};
    }
  }
  return picture;
}

TEST_CASE("picture tile: colours come back nearly, transparency exactly") {
  for (const bool is_opaque : {true, false}) {
    const cv::Mat4b picture = Picture(is_opaque);
    const std::string bytes = SerializePhotoTile(picture);
    const cv::Mat4b back = DeserializePhotoTile(bytes);
    REQUIRE(back.size() == picture.size());
    double most = 0.0;
    for (int row = 0; row < 64; ++row) {
      for (int col = 0; col < 64; ++col) {
        CHECK(back(row, col)[3] == picture(row, col)[3]);
        for (int i = 0; i < 3; ++i) {
          most = std::max(most, std::abs(double(back(row, col)[i]) - picture(row, col)[i]));
        }
      }
    }
    CHECK(most < 12.0);
    // Other programs see a JPEG.
    CHECK(DecodeImage(bytes, {}).size() == picture.size());
  }
}

TEST_CASE("picture tile: damage is refused or gives a picture, never a crash") {
  const std::string bytes = SerializePhotoTile(Picture(false));
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes;
    damaged[random() % damaged.size()] ^= static_cast<char>(1 << (random() % 8));
    if (i % 3 == 0) damaged.resize(random() % damaged.size());
    try {
      DeserializePhotoTile(damaged);
    } catch (const DamagedMap&) {
    }
  }
  CHECK_THROWS_AS(DeserializePhotoTile("no picture"), DamagedMap);
}

}  // namespace
}  // namespace freelsd
