// Labels that people drew on photographs of places that no model has seen. One file per place, one
// polygon per line: ID CLASS PHOTOGRAPH col row col row ..., in pixels of the stored photograph.
// Empty lines and lines that begin with # are skipped.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

namespace freelsd {

enum class PlaceClass {
  kGrass,
  // Too rough to land on. It counts as not grass, and is also reported apart.
  kRoughGrass,
  kCrop,
  kStubble,
  kSoil,
  kScrub,
  kTree,
  kWater,
  kPaved,
  kBuilt,
};
constexpr size_t kNumPlaceClasses = 10;

extern const std::array<std::string, 4> kPhotographExtensions;

// "grass", "rough_grass" and so on, as in the labels.
std::string NameOf(PlaceClass surface);
std::optional<PlaceClass> PlaceClassNamed(const std::string& name);

struct PlacePolygon {
  // Unique in its place.
  std::string id;
  PlaceClass surface = PlaceClass::kGrass;
  // File name without folder and extension. A line may give it with the extension of an image.
  std::string photograph;
  // (0, 0) is the centre of the top-left pixel.
  std::vector<cv::Point2d> outline_in_image;
};

// Throws std::runtime_error that names file and line if a line cannot be understood.
std::vector<PlacePolygon> ReadPlacePolygons(const std::string& path);

// Class that a second person gave to a polygon without seeing the first person's class, by place
// and id. One polygon per line: PLACE ID CLASS. The class "doubt" is no opinion and is left out.
// Throws as ReadPlacePolygons.
using SecondOpinions = std::map<std::pair<std::string, std::string>, PlaceClass>;
SecondOpinions ReadSecondOpinions(const std::string& path);

}  // namespace freelsd
