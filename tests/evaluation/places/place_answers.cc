#include "tests/evaluation/places/place_answers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kMaxNoRegionRatio = 0.5;
// Fewer pixels have no texture that could be measured.
constexpr int kMinNumPixels = 16;

Camera NadirCamera(const cv::Size& size, double focal_px) {
  Camera camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (size.width - 1);
  camera.cy_px = 0.5 * (size.height - 1);
  return camera;
}

void CheckOutline(const PlacePhotograph& photograph, const PlacePolygon& polygon) {
  const cv::Size size = photograph.image.size();
  for (const cv::Point2d& vertex : polygon.outline_in_image) {
    if (vertex.x >= 0 && vertex.x <= size.width && vertex.y >= 0 && vertex.y <= size.height) {
      continue;
    }
    throw std::runtime_error(photograph.place + "/" + photograph.name + ": polygon " + polygon.id +
                             " leaves the photograph of " + std::to_string(size.width) + "x" +
                             std::to_string(size.height) + " pixels");
  }
}

// The polygon's pixels in the photograph, 255, resampled to `size`.
cv::Mat1b MaskOf(const PlacePolygon& polygon, const cv::Size& photograph, const cv::Size& size) {
  std::vector<cv::Point> outline;
  outline.reserve(polygon.outline_in_image.size());
  for (const cv::Point2d& vertex : polygon.outline_in_image) {
    outline.emplace_back(cvRound(vertex.x), cvRound(vertex.y));
  }
  cv::Mat1b mask(photograph, uint8_t{0});
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{outline}, 255);
  cv::Mat1b resampled;
  cv::resize(mask, resampled, size, 0.0, 0.0, cv::INTER_NEAREST_EXACT);
  return resampled;
}

// Sets no_region_ratio and probability.
void AnswerByRegions(const cv::Mat1b& mask,
                     const Segments& segments,
                     const Labels& labels,
                     PolygonAnswer& answer) {
  int num_pixels = 0, num_in_region = 0;
  double sum = 0.0;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask(y, x) == 0) continue;
      ++num_pixels;
      const int label = segments.labels(y, x);
      if (label == 0) continue;
      ++num_in_region;
      sum += labels[static_cast<size_t>(label - 1)].probability;
    }
  }
  answer.no_region_ratio =
      num_pixels > 0 ? 1.0 - static_cast<double>(num_in_region) / num_pixels : 1.0;
  if (answer.no_region_ratio <= kMaxNoRegionRatio) answer.probability = sum / num_in_region;
}

// The engine's answer for a region with the polygon's pixels. `mask` has the size of the detail
// image.
std::optional<double> AnswerAsOneRegion(const cv::Mat1b& mask,
                                        const Segments& segments,
                                        const Classifier& classifier) {
  if (cv::countNonZero(mask) < kMinNumPixels) return std::nullopt;
  Segments one = segments;
  one.labels = cv::Mat1i(mask.size(), 0);
  one.labels.setTo(1, mask);
  one.segments.resize(1);
  one.segments.front().label = 1;
  return ClassifySegments(one, classifier, ClassificationOptions{}).front().probability;
}

Json OrNull(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

std::optional<double> NumberOf(const Json& json) {
  return json.is_null() ? std::nullopt : std::optional<double>(json.get<double>());
}

PlaceClass ClassOf(const Json& json) {
  const std::optional<PlaceClass> surface = PlaceClassNamed(json.get<std::string>());
  if (!surface) throw std::runtime_error(json.dump() + " is no class");
  return *surface;
}

Json ToJson(const PolygonAnswer& answer) {
  Json json{{"id", answer.id},
            {"class", NameOf(answer.surface)},
            {"area_m2", answer.area_m2},
            {"no_region_ratio", answer.no_region_ratio},
            {"probability", OrNull(answer.probability)},
            {"probability_as_one_region", OrNull(answer.probability_as_one_region)}};
  if (answer.second_opinion) json["second_opinion"] = NameOf(*answer.second_opinion);
  return json;
}

PolygonAnswer PolygonAnswerFromJson(const Json& json) {
  PolygonAnswer answer;
  answer.id = json.at("id").get<std::string>();
  answer.surface = ClassOf(json.at("class"));
  answer.area_m2 = json.at("area_m2").get<double>();
  answer.no_region_ratio = json.at("no_region_ratio").get<double>();
  answer.probability = NumberOf(json.at("probability"));
  answer.probability_as_one_region = NumberOf(json.at("probability_as_one_region"));
  if (json.contains("second_opinion")) answer.second_opinion = ClassOf(json.at("second_opinion"));
  return answer;
}

}  // namespace

double PxPerWorkingPx(double ground_sampling_m) {
  return std::max(1.0, SegmentationOptions{}.ground_sampling_distance_m / ground_sampling_m);
}

Segments SegmentsOf(const PlacePhotograph& photograph) {
  // Any height will do: only the ratio of height and focal length matters.
  constexpr double kHeightM = 100.0;
  const Camera camera =
      NadirCamera(photograph.image.size(), kHeightM / photograph.ground_sampling_m);
  return SegmentFrame(photograph.image, camera, kHeightM, SegmentationOptions{});
}

std::vector<PolygonAnswer> AnswersOf(const PlacePhotograph& photograph,
                                     const Segments& segments,
                                     const Classifier& classifier) {
  const Labels labels = ClassifySegments(segments, classifier, ClassificationOptions{});
  const cv::Size size = photograph.image.size();
  std::vector<PolygonAnswer> answers;
  answers.reserve(photograph.polygons.size());
  for (const PlacePolygon& polygon : photograph.polygons) {
    CheckOutline(photograph, polygon);
    PolygonAnswer answer;
    answer.id = polygon.id;
    answer.surface = polygon.surface;
    const cv::Mat1b in_detail = MaskOf(polygon, size, segments.detail_image.size());
    answer.area_m2 = cv::countNonZero(MaskOf(polygon, size, size)) * photograph.ground_sampling_m *
                     photograph.ground_sampling_m;
    AnswerByRegions(MaskOf(polygon, size, segments.image.size()), segments, labels, answer);
    answer.probability_as_one_region = AnswerAsOneRegion(in_detail, segments, classifier);
    answers.push_back(answer);
  }
  return answers;
}

void SwapKinds(PhotographAnswers& answers) {
  for (PolygonAnswer& answer : answers.polygons) {
    if (answer.probability) *answer.probability = 1.0 - *answer.probability;
    if (answer.probability_as_one_region) {
      *answer.probability_as_one_region = 1.0 - *answer.probability_as_one_region;
    }
  }
}

Json ToJson(const PhotographAnswers& answers) {
  Json polygons = Json::array();
  for (const PolygonAnswer& answer : answers.polygons) polygons.push_back(ToJson(answer));
  return {{"place", answers.place},
          {"photograph", answers.photograph},
          {"variation", answers.variation},
          {"ground_sampling_m", answers.ground_sampling_m},
          {"is_coarse", answers.is_coarse},
          {"polygons", polygons}};
}

PhotographAnswers PhotographAnswersFromJson(const Json& json) {
  PhotographAnswers answers;
  answers.place = json.at("place").get<std::string>();
  answers.photograph = json.at("photograph").get<std::string>();
  answers.variation = json.at("variation").get<std::string>();
  answers.ground_sampling_m = json.at("ground_sampling_m").get<double>();
  answers.is_coarse = json.at("is_coarse").get<bool>();
  for (const Json& polygon : json.at("polygons")) {
    answers.polygons.push_back(PolygonAnswerFromJson(polygon));
  }
  return answers;
}

}  // namespace freelsd
