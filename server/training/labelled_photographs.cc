#include "server/training/labelled_photographs.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "server/training/label_sheets.h"

namespace freelsd {
namespace {

namespace fs = std::filesystem;

// Ground sampling distance of photographs in memory; no feature uses finer detail.
constexpr double kStoredSamplingM = 0.15;

LabelledCamera CameraFor(const std::string& name, const std::vector<LabelledCamera>& cameras) {
  LabelledCamera mean{"", name.substr(0, name.find("__")), 0.0, 0.0};
  for (const LabelledCamera& camera : cameras) {
    if (name.starts_with(camera.prefix)) return camera;
    mean.focal_ratio += camera.focal_ratio / static_cast<double>(cameras.size());
    mean.height_m += camera.height_m / static_cast<double>(cameras.size());
  }
  return mean;
}

Camera NadirCamera(const cv::Size& size, double focal_ratio) {
  Camera camera;
  camera.width_px = size.width;
  camera.height_px = size.height;
  camera.fx_px = camera.fy_px = focal_ratio * size.width;
  camera.cx_px = 0.5 * (size.width - 1);
  camera.cy_px = 0.5 * (size.height - 1);
  return camera;
}

std::vector<fs::path> SortedFiles(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

LabelledPhotograph ReadPhotograph(const fs::path& path,
                                  const std::string& name,
                                  const std::vector<LabelledCamera>& cameras) {
  LabelledPhotograph photograph;
  photograph.name = name;
  photograph.image = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (photograph.image.empty()) throw std::runtime_error(path.string() + " is not an image");
  const LabelledCamera camera = CameraFor(name, cameras);
  photograph.place = camera.place;
  photograph.camera = NadirCamera(photograph.image.size(), camera.focal_ratio);
  photograph.height_above_ground = camera.height_m;
  photograph.mask = cv::Mat1b(photograph.image.size(), uint8_t{kUnlabelledClass});
  return photograph;
}

std::vector<std::vector<cv::Point>> ParseRings(const std::string& text) {
  std::vector<std::vector<cv::Point>> rings;
  std::istringstream ring_texts(text);
  std::string ring_text;
  while (std::getline(ring_texts, ring_text, '|')) {
    std::istringstream numbers(ring_text);
    std::vector<cv::Point> ring;
    cv::Point point;
    while (numbers >> point.x >> point.y) ring.push_back(point);
    rings.push_back(std::move(ring));
  }
  return rings;
}

struct OutlinedRegion {
  int surface_class = kUnlabelledClass;
  std::vector<std::vector<cv::Point>> rings;
};
using RegionsOfPhotographs = std::map<std::string, std::vector<OutlinedRegion>>;

RegionsOfPhotographs ReadLabelTable(const fs::path& path) {
  std::ifstream file(path);
  RegionsOfPhotographs regions;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line.front() == '#' || line == kLabelTableHeader) continue;
    std::istringstream cells(line);
    std::string photograph, number, surface_class, rings;
    std::getline(cells, photograph, ',');
    std::getline(cells, number, ',');
    std::getline(cells, surface_class, ',');
    std::getline(cells, rings);
    const bool is_class = surface_class.size() == 1 && surface_class[0] >= '0' &&
                          surface_class[0] < '0' + kNumClasses;
    if (!is_class || rings.empty()) {
      throw std::runtime_error(path.string() + ": cannot understand the line '" + line + "'");
    }
    regions[photograph].push_back({surface_class[0] - '0', ParseRings(rings)});
  }
  return regions;
}

LabelledPhotograph Reduced(LabelledPhotograph photograph) {
  const double scale =
      photograph.height_above_ground / photograph.camera.MeanFocalPx() / kStoredSamplingM;
  if (scale >= 1.0) return photograph;
  const double focal_ratio = photograph.camera.fx_px / photograph.camera.width_px;
  cv::Mat3b image;
  cv::resize(photograph.image, image, {}, scale, scale, cv::INTER_AREA);
  cv::Mat1b mask;
  cv::resize(photograph.mask, mask, image.size(), 0, 0, cv::INTER_NEAREST);
  photograph.image = image;
  photograph.mask = mask;
  photograph.camera = NadirCamera(image.size(), focal_ratio);
  return photograph;
}

}  // namespace

std::vector<LabelledCamera> ReadLabelledCameras(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read the cameras file " + path);
  std::vector<LabelledCamera> cameras;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line.front() == '#' || line.starts_with("prefix,")) continue;
    std::istringstream cells(line);
    LabelledCamera camera;
    char comma = 0;
    std::getline(cells, camera.prefix, ',');
    std::getline(cells, camera.place, ',');
    if (!(cells >> camera.focal_ratio >> comma >> camera.height_m) || camera.focal_ratio <= 0.0 ||
        camera.height_m <= 0.0) {
      throw std::runtime_error(path + ": cannot understand the line '" + line + "'");
    }
    cameras.push_back(camera);
  }
  if (cameras.empty()) throw std::runtime_error(path + ": names no camera");
  return cameras;
}

Photographs ReadLabelledPhotographs(const std::string& folder,
                                    const std::vector<LabelledCamera>& cameras) {
  Photographs photographs;
  for (const fs::path& path : SortedFiles(fs::path(folder) / "images")) {
    LabelledPhotograph photograph = ReadPhotograph(path, path.stem().string(), cameras);
    photograph.mask =
        cv::imread(folder + "/masks/" + photograph.name + ".png", cv::IMREAD_UNCHANGED);
    if (photograph.mask.size() != photograph.image.size()) {
      throw std::runtime_error(path.string() + ": needs an image and a mask of the same size");
    }
    photographs.push_back(std::move(photograph));
  }
  if (photographs.empty()) throw std::runtime_error(folder + ": holds no images");
  return photographs;
}

Photographs ReadLabelledFlights(const std::string& flights,
                                const std::string& tables,
                                const std::vector<LabelledCamera>& cameras) {
  Photographs photographs;
  for (const fs::path& table : SortedFiles(tables)) {
    if (table.extension() != ".csv") continue;
    const RegionsOfPhotographs regions = ReadLabelTable(table);
    const std::string flight = table.stem().string();
    for (const fs::path& path : FlightPaths(flights, flight)) {
      const auto outlined = regions.find(path.stem().string());
      if (outlined == regions.end()) continue;
      LabelledPhotograph photograph = ReadFlightPhotograph(path, flight, cameras);
      for (const OutlinedRegion& region : outlined->second) {
        cv::fillPoly(photograph.mask, region.rings, region.surface_class);
      }
      photographs.push_back(Reduced(std::move(photograph)));
    }
  }
  return photographs;
}

std::vector<fs::path> FlightPaths(const std::string& flights, const std::string& flight) {
  return SortedFiles(fs::path(flights) / flight / "images");
}

LabelledPhotograph ReadFlightPhotograph(const fs::path& path,
                                        const std::string& flight,
                                        const std::vector<LabelledCamera>& cameras) {
  return ReadPhotograph(path, flight + "__" + path.stem().string(), cameras);
}

}  // namespace freelsd
