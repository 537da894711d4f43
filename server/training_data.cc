#include "server/training_data.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr int kUnlabelled = 0;
constexpr int kGrass = 1;
constexpr int kDormantGrass = 9;
// Share of a tile that must carry its label: borders of polygons may cut a corner.
constexpr double kMinTilePurity = 0.9;
constexpr int kMinTileSidePx = 8;
// Limits of the variations, natural logarithm of a ratio unless the unit says otherwise.
constexpr double kMaxLogExposure = 0.5;
constexpr double kMaxLogWhiteBalance = 0.1;
// Paler grass than this is not worth the risk of learning leaf litter as grass.
constexpr double kMinLogSaturation = -0.2;
constexpr double kMaxLogSaturation = 0.6;
constexpr double kMaxLogSampling = 0.35;
constexpr double kMaxLogToldSampling = 0.2;
constexpr double kMaxNoiseSdGrey = 5.0;

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

struct Count {
  int num_pixels = 0;
  int num_grass = 0;
  int num_dormant = 0;
  int num_other = 0;
};

// Labels where `inside` is set.
Count CountLabels(const cv::Mat1b& mask, const cv::Mat1b& inside) {
  Count count;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (inside(y, x) == 0) continue;
      const int label = mask(y, x);
      ++count.num_pixels;
      count.num_grass += label == kGrass ? 1 : 0;
      count.num_dormant += label == kDormantGrass ? 1 : 0;
      count.num_other += label != kUnlabelled && label != kGrass && label != kDormantGrass ? 1 : 0;
    }
  }
  return count;
}

std::optional<bool> Majority(const Count& count, double min_labelled_ratio) {
  const int num_labelled = count.num_grass + count.num_other + count.num_dormant;
  if (num_labelled == 0 || num_labelled < min_labelled_ratio * count.num_pixels) {
    return std::nullopt;
  }
  if (count.num_dormant >= std::max(count.num_grass, count.num_other)) return std::nullopt;
  return count.num_grass > count.num_other;
}

cv::Mat3b Recoloured(const cv::Mat3b& image, const Variation& variation) {
  const auto saturation = static_cast<float>(variation.saturation_ratio);
  const auto grey_share = (1.0f - saturation) / 3.0f;
  const cv::Vec3f gain(static_cast<float>(variation.exposure_ratio * variation.blue_ratio),
                       static_cast<float>(variation.exposure_ratio),
                       static_cast<float>(variation.exposure_ratio * variation.red_ratio));
  cv::Matx33f colours = cv::Matx33f::all(grey_share);
  for (int channel = 0; channel < 3; ++channel) {
    colours(channel, channel) += saturation;
    for (int from = 0; from < 3; ++from) colours(channel, from) *= gain[channel];
  }
  cv::Mat3b recoloured;
  cv::transform(image, recoloured, colours);
  return recoloured;
}

cv::Mat3b WithNoise(const cv::Mat3b& image, const Variation& variation) {
  cv::Mat3s noise(image.size());
  cv::RNG generator(variation.noise_seed);
  generator.fill(noise, cv::RNG::NORMAL, 0.0, variation.noise_sd_grey);
  cv::Mat3b noisy;
  cv::add(image, noise, noisy, cv::noArray(), CV_8U);
  return noisy;
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

std::vector<Variation> Variations(int num_copies, uint64_t seed) {
  std::mt19937_64 generator(seed);
  // In [-1, 1]; by hand, since the standard's distributions differ between libraries.
  const auto symmetric = [&generator] {
    return 2.0 * static_cast<double>(generator() >> 11) / 9007199254740992.0 - 1.0;
  };
  std::vector<Variation> variations(1);
  for (int copy = 0; copy < num_copies; ++copy) {
    Variation variation;
    variation.exposure_ratio = std::exp(kMaxLogExposure * symmetric());
    variation.red_ratio = std::exp(kMaxLogWhiteBalance * symmetric());
    variation.blue_ratio = std::exp(kMaxLogWhiteBalance * symmetric());
    variation.saturation_ratio = std::exp(
        kMinLogSaturation + 0.5 * (kMaxLogSaturation - kMinLogSaturation) * (symmetric() + 1.0));
    variation.sampling_ratio = std::exp(kMaxLogSampling * symmetric());
    variation.told_sampling_ratio = std::exp(kMaxLogToldSampling * symmetric());
    variation.noise_sd_grey = kMaxNoiseSdGrey * std::abs(symmetric());
    variation.noise_seed = generator();
    variations.push_back(variation);
  }
  return variations;
}

LabelledRegions CutPhotograph(const LabelledPhotograph& photograph,
                              const Variation& variation,
                              double min_labelled_ratio) {
  SegmentationOptions options;
  options.ground_sampling_distance_m *= variation.sampling_ratio;
  LabelledRegions regions;
  regions.segments = SegmentFrame(Recoloured(photograph.image, variation),
                                  photograph.camera,
                                  photograph.height_above_ground,
                                  options);
  if (variation.noise_sd_grey > 0.0) {
    regions.segments.image = WithNoise(regions.segments.image, variation);
  }
  regions.segments.ground_sampling_distance_m *= variation.told_sampling_ratio;
  regions.mask = MaskAt(photograph.mask, regions.segments.image.size());
  for (const Segment& segment : regions.segments.segments) {
    const cv::Mat1b inside = regions.segments.labels == segment.label;
    regions.is_grass.push_back(Majority(CountLabels(regions.mask, inside), min_labelled_ratio));
  }
  return regions;
}

std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions, FeatureSet feature_set) {
  std::vector<TrainingSample> samples;
  for (size_t i = 0; i < regions.is_grass.size(); ++i) {
    if (!regions.is_grass[i]) continue;
    TrainingSample sample;
    sample.features = RegionFeatures(regions.segments.image,
                                     regions.segments.labels == regions.segments.segments[i].label,
                                     regions.segments.ground_sampling_distance_m,
                                     feature_set);
    sample.is_grass = *regions.is_grass[i];
    samples.push_back(std::move(sample));
  }
  return samples;
}

std::vector<TrainingSample> TileSamples(const LabelledRegions& regions,
                                        FeatureSet feature_set,
                                        double tile_m) {
  const cv::Mat1b& mask = regions.mask;
  const double ground_sampling = regions.segments.ground_sampling_distance_m;
  const int side = std::max(kMinTileSidePx, cvRound(tile_m / ground_sampling));
  // Half overlapping, for the small lawns' sake.
  const int step = side / 2;
  std::vector<TrainingSample> samples;
  for (int y = 0; y + side <= mask.rows; y += step) {
    for (int x = 0; x + side <= mask.cols; x += step) {
      const cv::Rect tile(x, y, side, side);
      const Count count = CountLabels(mask(tile), cv::Mat1b(tile.size(), uint8_t{1}));
      if (std::max(count.num_grass, count.num_other) < kMinTilePurity * tile.area()) continue;
      cv::Mat1b inside(mask.size(), uint8_t{0});
      inside(tile) = 255;
      TrainingSample sample;
      sample.features =
          RegionFeatures(regions.segments.image, inside, ground_sampling, feature_set);
      sample.is_grass = count.num_grass > count.num_other;
      samples.push_back(std::move(sample));
    }
  }
  return samples;
}

}  // namespace freelsd
