// The instrument that judges a ground_model on photographs of unseen places.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <unistd.h>

#include "tests/evaluation/places/place_answers.h"
#include "tests/evaluation/places/place_cameras.h"
#include "tests/evaluation/places/place_labels.h"
#include "tests/evaluation/places/place_report.h"
#include "tests/evaluation/places/place_run.h"
#include "tests/evaluation/places/place_scores.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kTolerance = 1e-12;

// A folder that is removed with everything in it.
struct TemporaryFolder {
  fs::path path = fs::temp_directory_path() / ("freelsd-places-" + std::to_string(getpid()));
  TemporaryFolder() { fs::create_directories(path / "labels"); }
  ~TemporaryFolder() { fs::remove_all(path); }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name) << text;
    return (path / name).string();
  }
};

// Green with fine texture on the left, grey on the right; 200 x 100 m at 0.5 m per pixel.
cv::Mat3b TwoFields(int seed) {
  cv::Mat3b image(200, 400, cv::Vec3b(120, 120, 120));
  image.colRange(0, 200).setTo(cv::Scalar(70, 130, 90));
  cv::Mat3s noise(image.size());
  cv::RNG generator(static_cast<uint64_t>(seed));
  generator.fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
  cv::Mat3b noisy;
  cv::add(image, noise, noisy, cv::noArray(), CV_8U);
  return noisy;
}

// A place "here" with `num_photographs` photographs of two fields each.
PlaceRunOptions MakePlace(const TemporaryFolder& folder, int num_photographs) {
  fs::create_directories(folder.path / "here");
  std::string labels;
  for (int i = 0; i < num_photographs; ++i) {
    const std::string number = std::to_string(i);
    cv::imwrite((folder.path / "here" / ("p" + number + ".png")).string(), TwoFields(i + 1));
    labels += "g" + number + " grass p" + number + ".png 20 20 180 20 180 180 20 180\n";
    labels += "b" + number + " built p" + number + " 220 20 380 20 380 180 220 180\n";
  }
  PlaceRunOptions options;
  options.photographs = folder.path.string();
  options.labels = (folder.path / "labels").string();
  folder.Write("labels/here.txt", labels);
  options.cameras = folder.Write("cameras.csv", "here,,0.5,made so\n");
  options.model = FREELSD_SOURCE_DIR "/engine/ground_kind/ground_kind.onnx";
  return options;
}

TEST_CASE("places: an error in the labels names file and line") {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& line) {
    const std::string path =
        folder.Write("place.txt", "# ID CLASS ...\na grass p 0 0 9 0 9 9\n" + line);
    try {
      ReadPlacePolygons(path);
    } catch (const std::runtime_error& error) {
      const std::string text = error.what();
      REQUIRE(text.starts_with(path + ":3: "));
      return text.substr(path.size() + 4);
    }
    return std::string("read");
  };
  CHECK(message("b grass") == "needs ID CLASS PHOTOGRAPH col row ...");
  CHECK(message("b lawn p 0 0 9 0 9 9") == "'lawn' is no class");
  CHECK(message("b grass p 0 0 9 0") == "a polygon needs at least three vertices");
  CHECK(message("b grass p 0 0 9 0 9 9 1") == "a column has no row");
  CHECK(message("b grass p 0 0 9 0 9 x9") == "'x9' is no number");
  CHECK(message("a grass p 0 0 9 0 9 9") == "the id a appears twice");
  CHECK(message("b rough_grass p 0 0 9 0 9 9.5") == "read");
  CHECK_THROWS_AS(ReadPlacePolygons(folder.path.string() + "/none.txt"), std::runtime_error);
}

TEST_CASE("places: an error in second opinions or cameras names file and line") {
  const TemporaryFolder folder;
  const std::string opinions = folder.Write("second.txt", "here a crop\nhere a crop\n");
  CHECK_THROWS_WITH_AS(ReadSecondOpinions(opinions),
                       (opinions + ":2: the polygon here a appears twice").c_str(),
                       std::runtime_error);
  CHECK(ReadSecondOpinions(folder.Write("second.txt", "here a crop\nhere b doubt\n")).size() == 1);
  const std::string cameras = folder.Write("cameras.csv", "here,,-1,guessed\n");
  CHECK_THROWS_WITH_AS(
      ReadPlaceCameras(cameras),
      (cameras + ":1: needs place,photograph_prefix,ground_sampling_m,source").c_str(),
      std::runtime_error);
}

TEST_CASE("places: the camera with the longest prefix is taken") {
  const TemporaryFolder folder;
  const std::vector<PlaceCamera> cameras = ReadPlaceCameras(folder.Write(
      "cameras.csv",
      "place,photograph_prefix,ground_sampling_m,source\nhere,IMG_1,0.2,a\nhere,,0.1,b, c\n"));
  CHECK(CameraOf("here", "IMG_12", cameras).ground_sampling_m == 0.2);
  CHECK(CameraOf("here", "IMG_2", cameras).source == "b, c");
  CHECK_THROWS_AS(CameraOf("there", "IMG_2", cameras), std::runtime_error);
}

TEST_CASE("places: figures of a set made by hand have their closed-form values") {
  const JudgedPolygons polygons{
      {0.95, true}, {0.85, false}, {0.85, true}, {0.35, true}, {0.05, false}, {1.0, true}};
  // Of eight pairs of grass and another, six are in order, one is a tie, one is not in order.
  CHECK(*AreaUnderCurveOf(polygons) == doctest::Approx(6.5 / 8.0).epsilon(kTolerance));
  // Bins: 1.95 predicted and 2 of 2; 1.7 and 1 of 2; 0.35 and 1 of 1; 0.05 and 0 of 1.
  CHECK(*CalibrationErrorOf(polygons) ==
        doctest::Approx((0.05 + 0.7 + 0.65 + 0.05) / 6.0).epsilon(kTolerance));
  CHECK(*ErrorOf(polygons, 0.7) == doctest::Approx(2.0 / 6.0).epsilon(kTolerance));
}

TEST_CASE("places: a figure without a denominator is unknown") {
  CHECK_FALSE(ErrorOf({}, 0.7));
  CHECK_FALSE(CalibrationErrorOf({}));
  CHECK_FALSE(AreaUnderCurveOf({{0.9, true}}));
}

TEST_CASE("places: a probability calibrated by construction has no calibration error") {
  JudgedPolygons polygons;
  for (int bin = 0; bin < 10; ++bin) {
    for (int i = 0; i < 20; ++i) polygons.push_back({0.1 * bin + 0.05, i < 2 * bin + 1});
  }
  CHECK(*CalibrationErrorOf(polygons) < 1e-9);
}

TEST_CASE("places: the report is the same for one job and two") {
  const TemporaryFolder folder;
  for (const int num_photographs : {1, 3}) {
    PlaceRunOptions options = MakePlace(folder, num_photographs);
    const std::string one = RunPlaces(options).dump();
    options.num_jobs = 2;
    CHECK(RunPlaces(options).dump() == one);
  }
}

TEST_CASE("places: polygons have the area that was drawn, and an answer") {
  const TemporaryFolder folder;
  const Json report = RunPlaces(MakePlace(folder, 1));
  const Json& polygons = report.at("photographs").at(0).at("polygons");
  REQUIRE(polygons.size() == 2);
  // 160 x 160 pixels of 0.5 m.
  constexpr double kMaxErrorM2 = 100.0;
  CHECK(std::abs(polygons.at(0).at("area_m2").get<double>() - 6400.0) < kMaxErrorM2);
  for (const Json& polygon : polygons) {
    CHECK(polygon.at("not_told_ratio") < 0.1);
    CHECK(polygon.at("probability").is_number());
  }
  CHECK(report.at("pooled").at("num_polygons") == 2);
}

TEST_CASE("places: a polygon that leaves its photograph is named") {
  const TemporaryFolder folder;
  const PlaceRunOptions options = MakePlace(folder, 1);
  folder.Write("labels/here.txt", "far grass p0 0 0 401 0 401 9\n");
  CHECK_THROWS_WITH_AS(RunPlaces(options),
                       "here/p0: polygon far leaves the photograph of 400x200 pixels",
                       std::runtime_error);
}

PhotographAnswers Answered(double grass, double built) {
  PhotographAnswers answers;
  answers.place = "here";
  answers.polygons.resize(2);
  answers.polygons[0] = {"a", PlaceClass::kGrass, std::nullopt, 1.0, 0.0, grass};
  answers.polygons[1] = {"b", PlaceClass::kBuilt, std::nullopt, 1.0, 0.0, built};
  return answers;
}

TEST_CASE("places: swapped kinds turn a perfect report into one worse than chance") {
  PhotographAnswers answers = Answered(0.9, 0.2);
  const auto auc = [&] {
    const Json report = MakePlaceReport({answers});
    CHECK(IsBetterThanChance(report) == (report.at("pooled").at("auc") == 1.0));
    return report.at("places").at("here").at("auc");
  };
  CHECK(auc() == 1.0);
  SwapKinds(answers);
  CHECK(auc() == 0.0);
}

TEST_CASE("places: polygons that two people see differently count for nothing") {
  PhotographAnswers answers = Answered(0.9, 0.995);
  answers.polygons[0].second_opinion = PlaceClass::kGrass;
  answers.polygons[1].second_opinion = PlaceClass::kPaved;
  const auto report = [&] { return MakePlaceReport({answers}); };
  const Json agreed = report();
  CHECK(agreed.at("second_opinion").at("differ_ratio") == 0.5);
  CHECK(agreed.at("second_opinion").at("differ_on_grass_ratio") == 0.0);
  CHECK(agreed.at("pooled").at("error") == 0.5);
  CHECK(agreed.at("pooled").at("num_sure_false_grass") == 1);
  answers.polygons[1].second_opinion = PlaceClass::kGrass;
  const Json disputed = report();
  CHECK(disputed.at("second_opinion").at("differ_on_grass_ratio") == 0.5);
  CHECK(disputed.at("pooled").at("num_disputed") == 1);
  CHECK(disputed.at("pooled").at("error") == 0.0);
  CHECK(disputed.at("pooled").at("num_sure_false_grass") == 0);
}

TEST_CASE("places: photographs of another scale stay out of the pooled row") {
  PhotographAnswers low = Answered(0.9, 0.2);
  low.place = "semantic_drone";
  const Json report = MakePlaceReport({low});
  CHECK(report.at("pooled").at("num_polygons") == 0);
  CHECK(report.at("other_scale").at("num_polygons") == 2);
}

}  // namespace
}  // namespace freelsd
