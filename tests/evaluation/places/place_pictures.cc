#include "tests/evaluation/places/place_pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kMaxWidthPx = 1600.0;
constexpr double kFontScale = 0.45;
const cv::Scalar kWhite(255, 255, 255);

cv::Scalar ColourOf(PlaceClass surface) {
  if (surface == PlaceClass::kGrass) return {60, 220, 60};
  if (surface == PlaceClass::kRoughGrass) return {0, 220, 255};
  return {60, 60, 255};
}

std::vector<cv::Point> Scaled(const std::vector<cv::Point2d>& outline, double scale) {
  std::vector<cv::Point> scaled;
  scaled.reserve(outline.size());
  for (const cv::Point2d& vertex : outline) {
    scaled.emplace_back(cvRound(vertex.x * scale), cvRound(vertex.y * scale));
  }
  return scaled;
}

std::string TextOf(const std::optional<double>& probability) {
  if (!probability) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << *probability;
  return text.str();
}

void Write(cv::Mat3b& picture, const std::string& text, const cv::Point& place) {
  constexpr int kOutlinePx = 3;
  for (const int thickness : {kOutlinePx, 1}) {
    cv::putText(picture,
                text,
                place,
                cv::FONT_HERSHEY_SIMPLEX,
                kFontScale,
                thickness > 1 ? cv::Scalar() : kWhite,
                thickness,
                cv::LINE_AA);
  }
}

void DrawRegions(cv::Mat3b& picture, const Segments& segments, double scale) {
  for (const Segment& segment : segments.segments) {
    std::vector<cv::Point> contour;
    contour.reserve(segment.contour_in_image.size());
    for (const Eigen::Vector2d& point : segment.contour_in_image) {
      contour.emplace_back(cvRound(point.x() * scale), cvRound(point.y() * scale));
    }
    cv::polylines(picture, contour, true, kWhite, 1);
  }
}

void DrawPolygon(cv::Mat3b& picture,
                 const PlacePolygon& polygon,
                 const PolygonAnswer& answer,
                 double scale) {
  constexpr size_t kNumLetters = 5;
  constexpr int kRightMarginPx = 130;
  const std::vector<cv::Point> outline = Scaled(polygon.outline_in_image, scale);
  cv::polylines(picture, outline, true, ColourOf(polygon.surface), 2, cv::LINE_AA);
  const cv::Rect box = cv::boundingRect(outline);
  const cv::Point place(std::clamp(box.x, 0, std::max(0, picture.cols - kRightMarginPx)),
                        box.y + box.height / 2);
  Write(picture,
        NameOf(polygon.surface).substr(0, kNumLetters) + " " + polygon.id + ": " +
            TextOf(answer.probability) + "/" + TextOf(answer.probability_as_one_region),
        place);
}

}  // namespace

void DrawPlaceAnswers(const std::string& folder,
                      const PlacePhotograph& photograph,
                      const Segments& segments,
                      const PhotographAnswers& answers) {
  const double scale = std::min(1.0, kMaxWidthPx / photograph.image.cols);
  cv::Mat3b picture;
  cv::resize(photograph.image, picture, {}, scale, scale, cv::INTER_AREA);
  DrawRegions(picture, segments, scale);
  for (size_t i = 0; i < photograph.polygons.size(); ++i) {
    DrawPolygon(picture, photograph.polygons[i], answers.polygons.at(i), scale);
  }
  std::filesystem::create_directories(folder);
  const std::string path =
      folder + "/" + photograph.place + "__" + photograph.name + "__" + answers.variation + ".png";
  if (!cv::imwrite(path, picture)) throw std::runtime_error("cannot write " + path);
}

}  // namespace freelsd
