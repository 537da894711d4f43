// Contrast against its closed form, quantiles and flags against values worked out by hand.
#include <cmath>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "tests/evaluation/frames/comparison.h"
#include "tests/evaluation/frames/labelled_picture.h"
#include "tests/evaluation/frames/rendered_pictures.h"
#include "tests/evaluation/frames/tile_measures.h"

namespace freelsd {
namespace {

constexpr double kGroundSamplingM = 0.215;

// Log brightness swings by `amplitude` along the columns.
cv::Mat1f Grating(double wavelength_px, double amplitude, int side_px) {
  cv::Mat1f grating(side_px, side_px);
  for (int row = 0; row < side_px; ++row) {
    for (int col = 0; col < side_px; ++col) {
      grating(row, col) =
          static_cast<float>(4.5 + amplitude * std::sin(2.0 * kPi * col / wavelength_px));
    }
  }
  return grating;
}

// Of a sine that is averaged over so many pixels.
double BoxGain(int side_px, double wavelength_px) {
  return std::sin(kPi * side_px / wavelength_px) / (side_px * std::sin(kPi / wavelength_px));
}

double ContrastOf(const cv::Mat1f& log_brightness, const Band& band, const cv::Rect& tile) {
  const cv::Mat1b inside(log_brightness.size(), uint8_t{255});
  cv::Scalar mean, deviation;
  cv::meanStdDev(BandOf(log_brightness, inside, band, kGroundSamplingM)(tile), mean, deviation);
  return deviation[0];
}

TEST_CASE("frames: the contrast of a grating is that of its closed form within 5 %") {
  constexpr double kMaxErrorRatio = 0.05;
  constexpr double kAmplitude = 0.2;
  // A tile of whole waves, far from the border.
  const cv::Rect tile(56, 56, 56, 56);
  for (const double wavelength_px : {4.0, 7.0, 14.0, 28.0}) {
    const cv::Mat1f grating = Grating(wavelength_px, kAmplitude, 168);
    for (const Band& band : kBands) {
      const double gain = BoxGain(BoxSidePx(band.fine_m, kGroundSamplingM), wavelength_px) -
                          BoxGain(BoxSidePx(band.coarse_m, kGroundSamplingM), wavelength_px);
      const double expected = kAmplitude / std::sqrt(2.0) * std::abs(gain);
      CHECK(ContrastOf(grating, band, tile) == doctest::Approx(expected).epsilon(kMaxErrorRatio));
    }
  }
}

TEST_CASE("frames: an 8 bit picture of a grating keeps its contrast within 5 %") {
  constexpr double kMaxErrorRatio = 0.05;
  constexpr double kAmplitude = 0.2, kWavelengthPx = 7.0;
  cv::Mat1f brightness;
  cv::exp(Grating(kWavelengthPx, kAmplitude, 168), brightness);
  cv::Mat1b grey;
  brightness.convertTo(grey, CV_8U, 1.0, -4.0);
  cv::Mat3b image;
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  const Band& band = kBands[0];
  const double gain = BoxGain(1, kWavelengthPx) - BoxGain(3, kWavelengthPx);
  CHECK(ContrastOf(LogBrightness(image), band, {56, 56, 56, 56}) ==
        doctest::Approx(kAmplitude / std::sqrt(2.0) * gain).epsilon(kMaxErrorRatio));
}

TEST_CASE("frames: what lies outside of a cover does not change its contrast") {
  cv::Mat1f log_brightness = Grating(7.0, 0.2, 168);
  cv::Mat1b inside(log_brightness.size(), uint8_t{0});
  const cv::Rect field(30, 30, 100, 100);
  inside(field) = 255;
  const cv::Mat1f before = BandOf(log_brightness, inside, kBands[3], kGroundSamplingM);
  log_brightness.setTo(0.0f, inside == 0);
  const cv::Mat1f after = BandOf(log_brightness, inside, kBands[3], kGroundSamplingM);
  CHECK(cv::norm(before, after, cv::NORM_INF) < 1e-5);
}

TEST_CASE("frames: boxes have the odd number of pixels nearest to their size") {
  CHECK(BoxSidePx(0.3, 0.215) == 1);
  CHECK(BoxSidePx(0.6, 0.215) == 3);
  CHECK(BoxSidePx(1.2, 0.215) == 5);
  CHECK(BoxSidePx(2.5, 0.215) == 11);
  CHECK(BoxSidePx(5.0, 0.215) == 23);
}

TEST_CASE("frames: tiles lie wholly within one cover and keep their distance from its border") {
  LabelledPicture picture;
  picture.ground_sampling_m = 0.5;
  picture.cover = cv::Mat1b(40, 40, static_cast<uint8_t>(Cover::kDoubt));
  picture.cover(cv::Rect(9, 9, 22, 22)) = static_cast<uint8_t>(Cover::kMeadow);
  // The lattice of 10 pixels has four squares in 10..29; a wider margin cuts all of them.
  const auto tiles = [&](double margin_m) {
    return TilesWithin(InsideOf(picture, Cover::kMeadow, margin_m), 10, 100);
  };
  CHECK(tiles(0.5).size() == 4);
  CHECK(tiles(1.0).empty());
  CHECK(TilesWithin(InsideOf(picture, Cover::kMeadow, 0.5), 10, 2).size() == 2);
  CHECK(TilesWithin(InsideOf(picture, Cover::kSoil, 0.0), 10, 100).empty());
}

TEST_CASE("frames: a picture that is too coarse is left out, a finer one is reduced") {
  LabelledPicture picture;
  picture.image = cv::Mat3b(40, 60, cv::Vec3b(10, 20, 30));
  picture.cover = cv::Mat1b(picture.image.size(), static_cast<uint8_t>(Cover::kSoil));
  picture.ground_sampling_m = 0.1;
  const auto reduced = AtScale(picture, 0.2);
  REQUIRE(reduced);
  CHECK(reduced->image.size() == cv::Size(30, 20));
  CHECK(reduced->cover.size() == cv::Size(30, 20));
  CHECK(reduced->ground_sampling_m == 0.2);
  CHECK(!AtScale(picture, 0.08));
  CHECK(AtScale(picture, 0.095)->image.size() == picture.image.size());
}

TEST_CASE("frames: quantiles are linear between neighbours") {
  const std::vector<double> values{3.0, 1.0, 2.0, 5.0, 4.0};
  CHECK(Quantile(values, 0.0) == 1.0);
  CHECK(Quantile(values, 0.5) == 3.0);
  CHECK(Quantile(values, 0.05) == doctest::Approx(1.2));
  CHECK(Quantile(values, 0.95) == doctest::Approx(4.8));
  CHECK(Quantile(values, 1.0) == 5.0);
  CHECK(std::isnan(Quantile({}, 0.5)));
}

TEST_CASE("frames: the distance outside of a spread is counted in its widths") {
  const Spread recorded{1.0, 2.0, 3.0};
  CHECK(DistanceOutside(1.0, recorded) == 0.0);
  CHECK(DistanceOutside(2.5, recorded) == 0.0);
  CHECK(DistanceOutside(4.0, recorded) == 0.5);
  CHECK(DistanceOutside(-1.0, recorded) == 1.0);
  CHECK(DistanceOutside(1.02, {1.0, 1.0, 1.0}) == doctest::Approx(2.0));
}

LookTiles TilesOf(double value, size_t num_tiles) {
  LookTiles tiles;
  for (size_t i = 0; i < num_tiles; ++i) {
    Measures measures{};
    measures.fill(value + 0.001 * static_cast<double>(i));
    tiles.measures.push_back(measures);
  }
  tiles.num_pictures = 1;
  return tiles;
}

TEST_CASE("frames: a world is flagged if its median lies outside of what photographs show") {
  TilesOfLooks tiles;
  tiles[Cover::kMeadow] = {{kRecorded, TilesOf(0.5, 20)},
                           {"alike", TilesOf(0.5, 20)},
                           {"other", TilesOf(0.9, 20)},
                           {"few", TilesOf(0.9, kMinNumTiles - 1)}};
  nlohmann::json report{{"pool", "tuning"}, {"tile_m", 6.0}, {"ground_sampling_m", 0.215}};
  report["covers"] = CompareLooks(tiles);
  const nlohmann::json& spreads = report["covers"]["meadow"]["measures"]["excess green"];
  CHECK(spreads["alike"]["distance_outside"] == 0.0);
  CHECK(spreads["other"]["distance_outside"].get<double>() > 1.0);
  CHECK(!spreads["few"].contains("distance_outside"));
  CHECK(!spreads[kRecorded].contains("distance_outside"));
  const std::string text = ComparisonAsMarkdown(report);
  CHECK(text.find("| meadow | excess green | other |") != std::string::npos);
  CHECK(text.find("| meadow | excess green | alike |") == std::string::npos);
}

TEST_CASE("frames: a run cannot render a seed of the other pool") {
  PoolOfRun run;
  run.Add("place snowpeak_ebee", Pool::kReport);
  const WorldLook look = WorldLooks(Pool::kReport, 3).front();
  CHECK_THROWS_WITH_AS(RenderPictures(0, look, run),
                       doctest::Contains("seed 0 is of the pool tuning"),
                       std::invalid_argument);
}

}  // namespace
}  // namespace freelsd
