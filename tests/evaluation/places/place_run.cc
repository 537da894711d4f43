#include "tests/evaluation/places/place_run.h"

#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include <opencv2/imgcodecs.hpp>

#include "tests/evaluation/campaign.h"
#include "tests/evaluation/places/place_answers.h"
#include "tests/evaluation/places/place_cameras.h"
#include "tests/evaluation/places/place_pictures.h"
#include "tests/evaluation/places/place_report.h"
#include "tests/evaluation/places/place_variation.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kSecondOpinionFile = "second_opinion.txt";

// Place, photograph and variation of an answered photograph.
using Key = std::tuple<std::string, std::string, std::string>;

Key KeyOf(const PhotographAnswers& answers) {
  return {answers.place, answers.photograph, answers.variation};
}

// The labels of one photograph.
struct Work {
  std::string place;
  std::string photograph;
  std::vector<PlacePolygon> polygons;
};

std::vector<fs::path> LabelFiles(const std::string& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".txt") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<std::string> PlacesOf(const PlaceRunOptions& options) {
  if (!options.places.empty()) return options.places;
  std::vector<std::string> places;
  for (const fs::path& path : LabelFiles(options.labels)) {
    if (path.filename() != kSecondOpinionFile) places.push_back(path.stem().string());
  }
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

// FNV-1a: tells texts apart in a report's settings.
std::string DigestOf(const std::string& text) {
  uint64_t digest = 14695981039346656037ULL;
  for (const char letter : text) {
    digest = (digest ^ static_cast<unsigned char>(letter)) * 1099511628211ULL;
  }
  std::ostringstream hex;
  hex << std::hex << std::setw(16) << std::setfill('0') << digest;
  return hex.str();
}

// Reports with other settings cannot be continued or merged.
Json SettingsOf(const PlaceRunOptions& options) {
  std::string labels = ReadTextFile(options.cameras);
  for (const fs::path& path : LabelFiles(options.labels)) {
    labels += path.filename().string() + "\n" + ReadTextFile(path.string());
  }
  Json settings{{"model", DigestOf(ReadTextFile(options.model))}, {"labels", DigestOf(labels)}};
  if (options.swaps_kinds) settings["blind"] = "kinds";
  return settings;
}

fs::path PathOf(const std::string& folder, const Work& work) {
  const fs::path in_place = fs::path(folder) / work.place;
  for (const std::string& extension : kPhotographExtensions) {
    fs::path path = in_place / (work.photograph + extension);
    if (fs::is_regular_file(path)) return path;
  }
  throw std::runtime_error("no photograph " + (in_place / work.photograph).string());
}

std::vector<PhotographAnswers> ReadAnswers(const PlaceRunOptions& options) {
  std::vector<PhotographAnswers> answers;
  if (!options.resumes) return answers;
  const Json report = ReadReportToContinue(options.json, SettingsOf(options));
  for (const Json& photograph : report.value("photographs", Json::array())) {
    answers.push_back(PhotographAnswersFromJson(photograph));
  }
  return answers;
}

SecondOpinions SecondOpinionsIn(const std::string& labels) {
  const fs::path path = fs::path(labels) / kSecondOpinionFile;
  return fs::exists(path) ? ReadSecondOpinions(path.string()) : SecondOpinions();
}

// Judges several photographs at once and collects the answers.
class PlaceRun {
 public:
  explicit PlaceRun(const PlaceRunOptions& options)
      : options_(options),
        settings_(SettingsOf(options)),
        classifier_(Classifier::Parse(ReadTextFile(options.model))),
        cameras_(ReadPlaceCameras(options.cameras)),
        opinions_(SecondOpinionsIn(options.labels)),
        work_(WorkOf(options)),
        answers_(ReadAnswers(options)) {
    for (const PhotographAnswers& answers : answers_) done_.insert(KeyOf(answers));
  }

  Json Run() {
    DoAll(work_.size(), options_.num_jobs, [&](size_t i) { Judge(work_[i]); });
    if (!options_.json.empty()) WriteReport();
    return MakePlaceReport(settings_, answers_);
  }

 private:
  void Judge(const Work& work) {
    PlacePhotograph photograph;
    for (const std::string& variation : options_.variations) {
      if (done_.contains({work.place, work.photograph, variation})) continue;
      if (photograph.image.empty()) photograph = Read(work);
      PlacePhotograph varied = photograph;
      varied.image = Varied(photograph.image,
                            PlaceVariationNamed(variation),
                            PxPerWorkingPx(photograph.ground_sampling_m));
      Keep(Answer(varied, variation));
    }
  }

  PlacePhotograph Read(const Work& work) const {
    const fs::path path = PathOf(options_.photographs, work);
    const cv::Mat image =
        cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (image.empty()) throw std::runtime_error(path.string() + " is not an image");
    const double ground_sampling_m =
        CameraOf(work.place, work.photograph, cameras_).ground_sampling_m;
    return {work.place, work.photograph, image, ground_sampling_m, work.polygons};
  }

  PhotographAnswers Answer(const PlacePhotograph& photograph, const std::string& variation) const {
    const Segments segments = SegmentsOf(photograph);
    PhotographAnswers answers;
    answers.place = photograph.place;
    answers.photograph = photograph.name;
    answers.variation = variation;
    answers.ground_sampling_m = photograph.ground_sampling_m;
    answers.is_coarse =
        photograph.ground_sampling_m >= SegmentationOptions{}.detail_sampling_distance_m;
    answers.polygons = AnswersOf(photograph, segments, classifier_);
    for (PolygonAnswer& answer : answers.polygons) {
      const auto opinion = opinions_.find({photograph.place, answer.id});
      if (opinion != opinions_.end()) answer.second_opinion = opinion->second;
    }
    if (options_.swaps_kinds) SwapKinds(answers);
    if (!options_.pictures.empty()) {
      DrawPlaceAnswers(options_.pictures, photograph, segments, answers);
    }
    return answers;
  }

  void Keep(PhotographAnswers answers) {
    const std::lock_guard<std::mutex> lock(mutex_);
    answers_.push_back(std::move(answers));
    if (!options_.json.empty()) WriteAnswers();
  }

  // Without figures, which take time; a report to continue from needs none.
  void WriteAnswers() const {
    Json photographs = Json::array();
    for (const PhotographAnswers& answers : answers_) photographs.push_back(ToJson(answers));
    const Json report{{"settings", settings_}, {"photographs", photographs}};
    WriteTextFile(options_.json, report.dump(1) + "\n");
  }

  void WriteReport() const {
    WriteTextFile(options_.json, MakePlaceReport(settings_, answers_).dump(1) + "\n");
  }

  const PlaceRunOptions& options_;
  const Json settings_;
  const Classifier classifier_;
  const std::vector<PlaceCamera> cameras_;
  const SecondOpinions opinions_;
  const std::vector<Work> work_;
  // What the report to continue from holds. It does not change during the run.
  std::set<Key> done_;
  // Guards answers_, which the jobs share, and the file of the answers.
  std::mutex mutex_;
  std::vector<PhotographAnswers> answers_;
};

}  // namespace

void PlaceRunOptions::Check() const {
  if (resumes && json.empty()) throw std::invalid_argument("--resume needs --json");
  if (num_jobs < 1) throw std::invalid_argument("--jobs must be at least 1");
  if (variations.empty()) throw std::invalid_argument("--variation: names none");
  const std::set<std::string> names(variations.begin(), variations.end());
  if (names.size() != variations.size()) {
    throw std::invalid_argument("--variation: names one twice");
  }
  for (const std::string& variation : variations) PlaceVariationNamed(variation);
}

Json RunPlaces(const PlaceRunOptions& options) {
  options.Check();
  // The jobs are the threads.
  cv::setNumThreads(1);
  return PlaceRun(options).Run();
}

Json MergePlaceReports(const std::vector<Json>& reports) {
  const Json settings = SharedSettings(reports);
  std::vector<PhotographAnswers> merged;
  std::set<Key> keys;
  for (const Json& report : reports) {
    for (const Json& photograph : report.at("photographs")) {
      merged.push_back(PhotographAnswersFromJson(photograph));
      const PhotographAnswers& answers = merged.back();
      if (!keys.insert(KeyOf(answers)).second) {
        throw std::runtime_error("the photograph " + answers.place + "/" + answers.photograph +
                                 ", variation " + answers.variation + ", is in two reports");
      }
    }
  }
  return MakePlaceReport(settings, std::move(merged));
}

}  // namespace freelsd
