#include "tests/evaluation/places/place_answers.h"

#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kMaxNoRegionRatio = 0.5;
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

// The regions that the engine finds in the photograph. The camera looks straight down.
Segments SegmentsOf(const PlacePhotograph& photograph) {
  // Any height will do: only the ratio of height and focal length matters.
  constexpr double kHeightM = 100.0;
  const Camera camera =
      NadirCamera(photograph.image.size(), kHeightM / photograph.ground_sampling_m);
  return SegmentFrame(photograph.image, camera, kHeightM, SegmentationOptions{});
}

Json ToJson(const PolygonAnswer& answer) {
  Json json{{"id", answer.id},
            {"class", NameOf(answer.surface)},
            {"area_m2", answer.area_m2},
            {"no_region_ratio", answer.no_region_ratio},
            {"probability", answer.probability ? Json(*answer.probability) : Json()}};
  if (answer.second_opinion) json["second_opinion"] = NameOf(*answer.second_opinion);
  return json;
}

}  // namespace

std::vector<PolygonAnswer> AnswersOf(const PlacePhotograph& photograph,
                                     const Classifier& classifier) {
  const Segments segments = SegmentsOf(photograph);
  const Labels labels = ClassifySegments(segments, classifier, ClassificationOptions{});
  const cv::Size size = photograph.image.size();
  std::vector<PolygonAnswer> answers;
  answers.reserve(photograph.polygons.size());
  for (const PlacePolygon& polygon : photograph.polygons) {
    CheckOutline(photograph, polygon);
    PolygonAnswer answer;
    answer.id = polygon.id;
    answer.surface = polygon.surface;
    answer.area_m2 = cv::countNonZero(MaskOf(polygon, size, size)) * photograph.ground_sampling_m *
                     photograph.ground_sampling_m;
    AnswerByRegions(MaskOf(polygon, size, segments.image.size()), segments, labels, answer);
    answers.push_back(answer);
  }
  return answers;
}

void SwapKinds(PhotographAnswers& answers) {
  for (PolygonAnswer& answer : answers.polygons) {
    if (answer.probability) *answer.probability = 1.0 - *answer.probability;
  }
}

Json ToJson(const PhotographAnswers& answers) {
  Json polygons = Json::array();
  for (const PolygonAnswer& answer : answers.polygons) polygons.push_back(ToJson(answer));
  return {{"place", answers.place},
          {"photograph", answers.photograph},
          {"ground_sampling_m", answers.ground_sampling_m},
          {"is_coarse", answers.is_coarse},
          {"polygons", polygons}};
}

}  // namespace freelsd
