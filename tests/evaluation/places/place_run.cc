#include "tests/evaluation/places/place_run.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>

#include "tests/evaluation/places/place_answers.h"
#include "tests/evaluation/places/place_cameras.h"
#include "tests/evaluation/places/place_report.h"
#include "tests/evaluation/runs/runs.h"
#include "tests/evaluation/synthetic_flight.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kSecondOpinionFile = "second_opinion.txt";

// The labels of one photograph.
struct Work {
  std::string place;
  std::string photograph;
  std::vector<PlacePolygon> polygons;
};

std::vector<std::string> PlacesOf(const PlaceRunOptions& options) {
  if (!options.places.empty()) return options.places;
  std::vector<std::string> places;
  for (const auto& entry : fs::directory_iterator(options.labels)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".txt" || path.filename() == kSecondOpinionFile) continue;
    places.push_back(path.stem().string());
  }
  std::sort(places.begin(), places.end());
  return places;
}

std::vector<Work> WorkOf(const PlaceRunOptions& options) {
  std::vector<Work> work;
  for (const std::string& place : PlacesOf(options)) {
    std::map<std::string, std::vector<PlacePolygon>> by_photograph;
    for (PlacePolygon& polygon : ReadPlacePolygons(options.labels + "/" + place + ".txt")) {
      by_photograph[polygon.photograph].push_back(std::move(polygon));
    }
    for (auto& [photograph, polygons] : by_photograph) {
      work.push_back({place, photograph, std::move(polygons)});
    }
  }
  return work;
}

fs::path PathOf(const std::string& folder, const Work& work) {
  const fs::path in_place = fs::path(folder) / work.place;
  for (const std::string& extension : kPhotographExtensions) {
    fs::path path = in_place / (work.photograph + extension);
    if (fs::is_regular_file(path)) return path;
  }
  throw std::runtime_error("no photograph " + (in_place / work.photograph).string());
}

SecondOpinions SecondOpinionsIn(const std::string& labels) {
  const fs::path path = fs::path(labels) / kSecondOpinionFile;
  return fs::exists(path) ? ReadSecondOpinions(path.string()) : SecondOpinions();
}

PlacePhotograph Read(const PlaceRunOptions& options,
                     const Work& work,
                     const std::vector<PlaceCamera>& cameras) {
  const fs::path path = PathOf(options.photographs, work);
  const cv::Mat image = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (image.empty()) throw std::runtime_error(path.string() + " is not an image");
  const double ground_sampling_m = CameraOf(work.place, work.photograph, cameras).ground_sampling_m;
  return {work.place, work.photograph, image, ground_sampling_m, work.polygons};
}

PhotographAnswers Answer(const PlacePhotograph& photograph,
                         const KindModel& model,
                         const SecondOpinions& opinions) {
  PhotographAnswers answers;
  answers.place = photograph.place;
  answers.photograph = photograph.name;
  answers.ground_sampling_m = photograph.ground_sampling_m;
  answers.polygons = AnswersOf(photograph, model);
  for (PolygonAnswer& answer : answers.polygons) {
    const auto opinion = opinions.find({photograph.place, answer.id});
    if (opinion != opinions.end()) answer.second_opinion = opinion->second;
  }
  return answers;
}

}  // namespace

Json RunPlaces(const PlaceRunOptions& options) {
  // The jobs are the threads.
  cv::setNumThreads(1);
  const std::vector<PlaceCamera> cameras = ReadPlaceCameras(options.cameras);
  const SecondOpinions opinions = SecondOpinionsIn(options.labels);
  const std::vector<Work> work = WorkOf(options);
  std::vector<PhotographAnswers> answers(work.size());
  DoAll(work.size(), options.num_jobs, [&](size_t i) {
    const std::string file =
        options.model.empty() ? FoldModelOf(work[i].place).value() : options.model;
    const KindModel model = std::get<KindModel>(ReadGroundModel(file).model);
    answers[i] = Answer(Read(options, work[i], cameras), model, opinions);
    if (options.swaps_kinds) SwapKinds(answers[i]);
  });
  return MakePlaceReport(std::move(answers));
}

}  // namespace freelsd
