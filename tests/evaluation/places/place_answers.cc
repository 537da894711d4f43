#include "tests/evaluation/places/place_answers.h"

#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

using Json = nlohmann::json;

constexpr double kMaxNotToldRatio = 0.5;

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

// Sets not_told_ratio and probability. The mask has the size of the picture.
void Answer(const cv::Mat1b& mask, const KindPicture& picture, PolygonAnswer& answer) {
  int num_pixels = 0, num_told = 0;
  double sum = 0.0;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (mask(y, x) == 0) continue;
      ++num_pixels;
      if (picture.grass(y, x) == 0) continue;
      ++num_told;
      sum += (picture.grass(y, x) - 1) / 254.0;
    }
  }
  answer.not_told_ratio = num_pixels > 0 ? 1.0 - static_cast<double>(num_told) / num_pixels : 1.0;
  if (answer.not_told_ratio <= kMaxNotToldRatio) answer.probability = sum / num_told;
}

Json ToJson(const PolygonAnswer& answer) {
  Json json{{"id", answer.id},
            {"class", NameOf(answer.surface)},
            {"area_m2", answer.area_m2},
            {"not_told_ratio", answer.not_told_ratio},
            {"probability", answer.probability ? Json(*answer.probability) : Json()}};
  if (answer.second_opinion) json["second_opinion"] = NameOf(*answer.second_opinion);
  return json;
}

}  // namespace

std::vector<PolygonAnswer> AnswersOf(const PlacePhotograph& photograph, const KindModel& model) {
  const KindPicture picture =
      KindNetwork(model).Tell(photograph.image, photograph.ground_sampling_m);
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
    Answer(MaskOf(polygon, size, picture.grass.size()), picture, answer);
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
          {"polygons", polygons}};
}

}  // namespace freelsd
