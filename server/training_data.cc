#include "server/training_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr int kUnlabelled = 0;
constexpr int kGrass = 1;
constexpr int kDormantGrass = 9;
constexpr int kNumLabels = 256;
// Share of a tile that must carry its label: borders of polygons may cut a corner.
constexpr double kMinTilePurity = 0.98;

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

// Pixels of each label where `inside` is set.
std::array<int, kNumLabels> CountLabels(const cv::Mat1b& mask, const cv::Mat1b& inside) {
  std::array<int, kNumLabels> counts{};
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (inside(y, x) != 0) ++counts[mask(y, x)];
    }
  }
  return counts;
}

// How other cameras, exposures and light would have shown the same ground.
struct Rendering {
  double gain;
  double saturation;
  // Factors on blue and red: cold or warm light.
  double blue;
  double red;
};
constexpr Rendering kRenderings[] = {{1.0, 1.0, 1.0, 1.0},
                                     {0.65, 1.0, 1.0, 1.0},
                                     {1.35, 1.0, 1.0, 1.0},
                                     {1.0, 0.75, 1.0, 1.0},
                                     {1.0, 1.35, 1.0, 1.0},
                                     {1.0, 1.0, 0.9, 1.08},
                                     {1.0, 1.0, 1.1, 0.94}};

cv::Mat3b Rendered(const cv::Mat3b& image, const Rendering& rendering) {
  cv::Mat3b rendered(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& bgr = image(y, x);
      const double grey = (bgr[0] + bgr[1] + bgr[2]) / 3.0;
      const double factors[] = {rendering.blue, 1.0, rendering.red};
      for (int i = 0; i < 3; ++i) {
        const double saturated = grey + rendering.saturation * (bgr[i] - grey);
        rendered(y, x)[i] = cv::saturate_cast<uint8_t>(rendering.gain * factors[i] * saturated);
      }
    }
  }
  return rendered;
}

// One sample per rendering.
std::vector<TrainingSample> SamplesOf(const std::vector<cv::Mat3b>& renderings,
                                      const cv::Mat1b& inside,
                                      double ground_sampling_distance_m,
                                      FeatureSet feature_set,
                                      const TrainingSample& label) {
  std::vector<TrainingSample> samples;
  for (const cv::Mat3b& image : renderings) {
    samples.push_back(label);
    samples.back().features =
        RegionFeatures(image, inside, ground_sampling_distance_m, feature_set);
  }
  return samples;
}

std::vector<cv::Mat3b> RenderingsOf(const cv::Mat3b& image, Augmentation augmentation) {
  std::vector<cv::Mat3b> renderings;
  for (const Rendering& rendering : kRenderings) {
    renderings.push_back(Rendered(image, rendering));
    if (augmentation == Augmentation::kNone) break;
  }
  return renderings;
}

cv::Mat1b MaskAt(const cv::Mat1b& mask, const cv::Size& size) {
  cv::Mat1b resized;
  cv::resize(mask, resized, size, 0, 0, cv::INTER_NEAREST);
  return resized;
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

std::vector<LabelledPhotograph> ReadLabelledPhotographs(
    const std::string& folder, const std::vector<LabelledCamera>& cameras) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/images")) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<LabelledPhotograph> photographs;
  for (const std::filesystem::path& path : paths) {
    LabelledPhotograph photograph;
    photograph.name = path.stem().string();
    photograph.image = cv::imread(path.string(), cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    photograph.mask =
        cv::imread(folder + "/masks/" + photograph.name + ".png", cv::IMREAD_UNCHANGED);
    if (photograph.image.empty() || photograph.mask.size() != photograph.image.size()) {
      throw std::runtime_error(path.string() + ": needs an image and a mask of the same size");
    }
    const LabelledCamera camera = CameraFor(photograph.name, cameras);
    photograph.place = camera.place;
    photograph.camera = NadirCamera(photograph.image.size(), camera.focal_ratio);
    photograph.height_above_ground = camera.height_m;
    photographs.push_back(std::move(photograph));
  }
  if (photographs.empty()) throw std::runtime_error(folder + ": holds no images");
  return photographs;
}

std::vector<TrainingSample> RegionSamples(const LabelledPhotograph& photograph,
                                          FeatureSet feature_set,
                                          double min_labelled_ratio,
                                          Augmentation augmentation) {
  const Segments segments = SegmentFrame(
      photograph.image, photograph.camera, photograph.height_above_ground, SegmentationOptions{});
  const cv::Mat1b mask = MaskAt(photograph.mask, segments.labels.size());
  const std::vector<cv::Mat3b> renderings = RenderingsOf(segments.image, augmentation);
  std::vector<TrainingSample> samples;
  for (const Segment& segment : segments.segments) {
    const cv::Mat1b inside = segments.labels == segment.label;
    const std::array<int, kNumLabels> counts = CountLabels(mask, inside);
    const int num_pixels = cv::countNonZero(inside);
    const int num_labelled = num_pixels - counts[kUnlabelled];
    const auto majority = std::max_element(counts.begin() + 1, counts.end());
    const auto label = static_cast<int>(majority - counts.begin());
    if (num_labelled < min_labelled_ratio * num_pixels || label == kDormantGrass) continue;
    const std::vector<TrainingSample> added = SamplesOf(renderings,
                                                        inside,
                                                        segments.ground_sampling_distance_m,
                                                        feature_set,
                                                        {{}, label == kGrass, photograph.place});
    samples.insert(samples.end(), added.begin(), added.end());
  }
  return samples;
}

std::vector<TrainingSample> TileSamples(const LabelledPhotograph& photograph,
                                        FeatureSet feature_set,
                                        double tile_m,
                                        Augmentation augmentation) {
  // The working image of the segmentation, so that tiles look like regions do.
  const Segments segments = SegmentFrame(
      photograph.image, photograph.camera, photograph.height_above_ground, SegmentationOptions{});
  const cv::Mat1b mask = MaskAt(photograph.mask, segments.image.size());
  const std::vector<cv::Mat3b> renderings = RenderingsOf(segments.image, augmentation);
  const int side = std::max(8, cvRound(tile_m / segments.ground_sampling_distance_m));
  std::vector<TrainingSample> samples;
  for (int y = 0; y + side <= mask.rows; y += side / 2) {
    for (int x = 0; x + side <= mask.cols; x += side / 2) {
      const cv::Rect tile(x, y, side, side);
      const std::array<int, kNumLabels> counts =
          CountLabels(mask(tile), cv::Mat1b(tile.size(), uint8_t{1}));
      const auto majority = std::max_element(counts.begin() + 1, counts.end());
      const auto label = static_cast<int>(majority - counts.begin());
      if (*majority < kMinTilePurity * side * side || label == kDormantGrass) continue;
      cv::Mat1b inside(mask.size(), uint8_t{0});
      inside(tile) = 255;
      const std::vector<TrainingSample> added = SamplesOf(renderings,
                                                          inside,
                                                          segments.ground_sampling_distance_m,
                                                          feature_set,
                                                          {{}, label == kGrass, photograph.place});
      samples.insert(samples.end(), added.begin(), added.end());
    }
  }
  return samples;
}

}  // namespace freelsd
