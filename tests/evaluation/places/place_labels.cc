#include "tests/evaluation/places/place_labels.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <stdexcept>

namespace freelsd {
namespace {

constexpr std::array<const char*, kNumPlaceClasses> kNames{
    "grass", "rough_grass", "crop", "stubble", "soil", "scrub", "tree", "water", "paved", "built"};
constexpr size_t kMinNumVertices = 3;
constexpr const char* kDoubt = "doubt";

PlaceClass ClassNamed(const std::string& name) {
  const std::optional<PlaceClass> surface = PlaceClassNamed(name);
  if (!surface) throw std::runtime_error("'" + name + "' is no class");
  return *surface;
}

std::vector<cv::Point2d> ParseOutline(std::istringstream& words) {
  std::vector<double> numbers;
  std::string word;
  while (words >> word) {
    std::istringstream text(word);
    double number = 0.0;
    if (!(text >> number) || !text.eof()) {
      throw std::runtime_error("'" + word + "' is no number");
    }
    numbers.push_back(number);
  }
  if (numbers.size() % 2 != 0) throw std::runtime_error("a column has no row");
  if (numbers.size() < 2 * kMinNumVertices) {
    throw std::runtime_error("a polygon needs at least three vertices");
  }
  std::vector<cv::Point2d> outline;
  outline.reserve(numbers.size() / 2);
  for (size_t i = 0; i < numbers.size(); i += 2) outline.emplace_back(numbers[i], numbers[i + 1]);
  return outline;
}

std::string WithoutExtension(const std::string& photograph) {
  for (const std::string& extension : kPhotographExtensions) {
    if (!photograph.ends_with(extension)) continue;
    return photograph.substr(0, photograph.size() - extension.size());
  }
  return photograph;
}

PlacePolygon ParsePolygon(const std::string& line) {
  std::istringstream words(line);
  PlacePolygon polygon;
  std::string surface;
  if (!(words >> polygon.id >> surface >> polygon.photograph)) {
    throw std::runtime_error("needs ID CLASS PHOTOGRAPH col row ...");
  }
  polygon.photograph = WithoutExtension(polygon.photograph);
  polygon.surface = ClassNamed(surface);
  polygon.outline_in_image = ParseOutline(words);
  return polygon;
}

// Gives each line that is neither empty nor a comment to `parse`, whose std::runtime_error becomes
// one that names file and line.
void ForEachLine(const std::string& path, const std::function<void(const std::string&)>& parse) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.front() == '#') continue;
    try {
      parse(line);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
}

}  // namespace

const std::array<std::string, 4> kPhotographExtensions{".jpg", ".JPG", ".png", ".tif"};

std::string NameOf(PlaceClass surface) { return kNames.at(static_cast<size_t>(surface)); }

std::optional<PlaceClass> PlaceClassNamed(const std::string& name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<PlaceClass>(found - kNames.begin());
}

std::vector<PlacePolygon> ReadPlacePolygons(const std::string& path) {
  std::vector<PlacePolygon> polygons;
  std::set<std::string> ids;
  ForEachLine(path, [&](const std::string& line) {
    polygons.push_back(ParsePolygon(line));
    const std::string& id = polygons.back().id;
    if (!ids.insert(id).second) throw std::runtime_error("the id " + id + " appears twice");
  });
  return polygons;
}

SecondOpinions ReadSecondOpinions(const std::string& path) {
  SecondOpinions opinions;
  ForEachLine(path, [&](const std::string& line) {
    std::istringstream words(line);
    std::string place, id, surface, rest;
    if (!(words >> place >> id >> surface) || words >> rest) {
      throw std::runtime_error("needs PLACE ID CLASS");
    }
    if (surface == kDoubt) return;
    if (!opinions.emplace(std::pair(place, id), ClassNamed(surface)).second) {
      throw std::runtime_error("the polygon " + place + " " + id + " appears twice");
    }
  });
  return opinions;
}

}  // namespace freelsd
