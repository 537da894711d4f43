// Textures of recorded ground: made of a piece whose mean and deviation are known.
#include "tests/synthetic/texture/texture.h"

#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int kSidePx = 60;

// Grey grains around 120, and a lens that darkens one side.
cv::Mat3b GrainyPiece(double sd, double darkening) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, sd);
  cv::Mat3b piece(kSidePx, kSidePx);
  for (int row = 0; row < kSidePx; ++row) {
    for (int col = 0; col < kSidePx; ++col) {
      const double slow = darkening * (static_cast<double>(col) / kSidePx - 0.5);
      piece(row, col) = cv::Vec3b::all(cv::saturate_cast<uint8_t>(120.0 + slow + normal(random)));
    }
  }
  return piece;
}

cv::Mat1f Picture(const RecordedTexture& texture, int side_px) {
  cv::Mat1f picture(side_px, side_px);
  for (int row = 0; row < side_px; ++row) {
    for (int col = 0; col < side_px; ++col) picture(row, col) = texture.At(col - 50, row - 80)[1];
  }
  return picture;
}

TEST_CASE("texture: mean and deviation are those of the piece, without the lens's shade") {
  constexpr double kSd = 12.0;
  constexpr double kMaxErrorOfMean = 0.8;
  constexpr double kMaxErrorOfSd = 1.0;
  const RecordedTexture texture(GrainyPiece(kSd, 60.0), 7);
  cv::Scalar mean, sd;
  cv::meanStdDev(Picture(texture, 400), mean, sd);
  CHECK(std::abs(mean[0] - 120.0) < kMaxErrorOfMean);
  CHECK(std::abs(sd[0] - kSd) < kMaxErrorOfSd);
}

TEST_CASE("texture: it does not repeat, and the same seed gives the same picture") {
  const RecordedTexture texture(GrainyPiece(12.0, 0.0), 7);
  const cv::Mat1f picture = Picture(texture, 300);
  CHECK(cv::norm(picture, Picture(RecordedTexture(GrainyPiece(12.0, 0.0), 7), 300)) == 0.0);
  CHECK(cv::norm(picture, Picture(RecordedTexture(GrainyPiece(12.0, 0.0), 8), 300)) > 0.0);
  // Shifted by any few pieces it is another picture.
  for (const int shift : {kSidePx, 2 * kSidePx}) {
    const cv::Mat1f one = picture.colRange(0, 100), other = picture.colRange(shift, shift + 100);
    CHECK(cv::norm(one, other, cv::NORM_L1) / static_cast<double>(one.total()) > 5.0);
  }
}

TEST_CASE("texture: a piece too narrow to blend is refused") {
  CHECK_THROWS_WITH_AS(RecordedTexture(cv::Mat3b(8, 40, cv::Vec3b::all(9)), 1),
                       "texture: a piece is 8 pixels wide: must be at least 12",
                       std::invalid_argument);
}

TEST_CASE("texture: no photograph is worn by both pools, and places split by photograph say so") {
  std::map<std::string, std::string> pool_of_photograph;
  std::map<std::string, std::set<std::string>> pools_of_place;
  const auto place_of = [](const std::string& path) { return path.substr(0, path.rfind('/')); };
  for (const TextureSource& source : ReadTextureSources()) {
    const auto [entry, is_new] = pool_of_photograph.try_emplace(source.photograph, source.pool);
    CHECK_MESSAGE(entry->second == source.pool, source.photograph);
    pools_of_place[place_of(source.photograph)].insert(source.pool);
  }
  for (const TextureSource& source : ReadTextureSources()) {
    const bool is_split = pools_of_place.at(place_of(source.photograph)).size() > 1;
    CHECK_MESSAGE(is_split == (source.split == "photograph"), source.photograph);
  }
}

TEST_CASE("texture: a clothed world keeps its brightness, and its crops are painted") {
  if (std::getenv("FREELSD_DATA") == nullptr) {
    MESSAGE("skipped: FREELSD_DATA is not set");
    return;
  }
  constexpr double kMaxChangeRatio = 0.05;
  WorldOptions options;
  options.seed = 1000;
  options.size_m = 200.0;
  options.cell_size_m = 0.2;
  const World painted = MakeCountryside(options);
  World world = MakeCountryside(options);
  Clothe(world, Wardrobe::Read("tuning", options.cell_size_m));
  const cv::Mat1b is_meadow = world.cover == static_cast<int>(Cover::kMeadow);
  REQUIRE(cv::countNonZero(is_meadow) > 1000);
  const cv::Scalar before = cv::mean(painted.albedo, is_meadow);
  const cv::Scalar after = cv::mean(world.albedo, is_meadow);
  const double brightness = before[0] + before[1] + before[2];
  CHECK(std::abs(after[0] + after[1] + after[2] - brightness) < kMaxChangeRatio * brightness);
  CHECK(cv::countNonZero(is_meadow & (world.is_textured == 0)) == 0);
  CHECK(cv::countNonZero((world.cover == static_cast<int>(Cover::kCrop)) & world.is_textured) == 0);
}

}  // namespace
}  // namespace freelsd
