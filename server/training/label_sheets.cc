#include "server/training/label_sheets.h"

#include <sstream>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// Tolerance for simplifying outlines, in working pixels; it keeps tables small.
constexpr double kOutlineTolerancePx = 1.5;
// Smaller holes are left out. Working pixels.
constexpr double kMinHoleAreaPx = 40.0;

using Ring = std::vector<cv::Point>;

std::vector<Ring> RingsOf(const cv::Mat1b& mask) {
  std::vector<Ring> rings, kept;
  std::vector<cv::Vec4i> hierarchy;
  cv::findContours(mask, rings, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_SIMPLE);
  for (size_t i = 0; i < rings.size(); ++i) {
    const bool is_hole = hierarchy[i][3] >= 0;
    if (is_hole && cv::contourArea(rings[i]) < kMinHoleAreaPx) continue;
    Ring simple;
    cv::approxPolyDP(rings[i], simple, kOutlineTolerancePx, true);
    if (simple.size() >= 3) kept.push_back(simple);
  }
  return kept;
}

// The pixel of a region that is farthest from its outline.
cv::Point InnermostPixel(const cv::Mat1b& mask) {
  cv::Mat1b framed;
  cv::copyMakeBorder(mask, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
  cv::Mat1f distance;
  cv::distanceTransform(framed, distance, cv::DIST_L2, cv::DIST_MASK_3);
  cv::Point innermost;
  cv::minMaxLoc(distance, nullptr, nullptr, nullptr, &innermost);
  return innermost - cv::Point(1, 1);
}

void DrawNumber(cv::Mat3b& sheet, int number, const cv::Point& at) {
  const std::string text = std::to_string(number);
  const cv::Point origin = at - cv::Point(6 * static_cast<int>(text.size()), -6);
  cv::putText(sheet, text, origin, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 0, 0}, 4, cv::LINE_AA);
  cv::putText(sheet, text, origin, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 255, 255}, 1, cv::LINE_AA);
}

}  // namespace

std::string RegionRows(const LabelledPhotograph& photograph, const Segments& segments) {
  // The file name without the flight's name.
  const size_t stem = photograph.name.find("__");
  const std::string name =
      stem == std::string::npos ? photograph.name : photograph.name.substr(stem + 2);
  std::ostringstream rows;
  for (const Segment& segment : segments.segments) {
    rows << name << "," << segment.label << ",0,";
    const char* separator = "";
    for (const Ring& ring : RingsOf(segments.labels == segment.label)) {
      rows << separator;
      separator = "|";
      const char* space = "";
      for (const cv::Point& point : ring) {
        rows << space << cvRound((point.x + 0.5) * segments.image_px_per_working_px - 0.5) << " "
             << cvRound((point.y + 0.5) * segments.image_px_per_working_px - 0.5);
        space = " ";
      }
    }
    rows << "\n";
  }
  return rows.str();
}

cv::Mat3b RegionSheet(const LabelledPhotograph& photograph,
                      const Segments& segments,
                      int width_px) {
  const double scale = static_cast<double>(width_px) / photograph.image.cols;
  const double sheet_px_per_working_px = scale * segments.image_px_per_working_px;
  cv::Mat3b sheet;
  cv::resize(photograph.image, sheet, {}, scale, scale, cv::INTER_AREA);
  for (const Segment& segment : segments.segments) {
    cv::Mat1b mask;
    cv::resize(segments.labels == segment.label, mask, sheet.size(), 0.0, 0.0, cv::INTER_NEAREST);
    std::vector<Ring> rings;
    cv::findContours(mask, rings, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
    cv::drawContours(sheet, rings, -1, {0, 0, 255});
  }
  for (const Segment& segment : segments.segments) {
    const cv::Point at = InnermostPixel(segments.labels == segment.label);
    DrawNumber(sheet,
               segment.label,
               {cvRound(at.x * sheet_px_per_working_px), cvRound(at.y * sheet_px_per_working_px)});
  }
  cv::putText(sheet, photograph.name, {6, 20}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {0, 0, 0}, 4);
  cv::putText(sheet, photograph.name, {6, 20}, cv::FONT_HERSHEY_SIMPLEX, 0.6, {255, 255, 255}, 1);
  return sheet;
}

}  // namespace freelsd
