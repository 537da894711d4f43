#include "server/training/training_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

constexpr double kTileM = 10.0;
// A region has the class of its majority if at least this share of its pixels is labelled.
constexpr double kMinLabelledRatio = 0.3;
// Smaller than the pipeline's least area, because small regions are useful samples too.
constexpr double kMinTrainingAreaM2 = 30.0;
// Share of a tile that must have one class; below 1, because a polygon's border may cut a corner.
constexpr double kMinTilePurity = 0.9;
constexpr int kMinTileSidePx = 8;
// Limits of the variations: natural logarithm of a ratio unless the name has another unit.
constexpr double kMaxLogExposure = 0.5;
constexpr double kMaxLogWhiteBalance = 0.1;
// With paler copies of grass, a forest may learn leaf litter as grass.
constexpr double kMinLogSaturation = -0.2;
constexpr double kMaxLogSaturation = 0.6;
constexpr double kMaxLogSampling = 0.35;
constexpr double kMaxLogToldSampling = 0.2;
constexpr double kMaxNoiseSdGrey = 2.0;

// Number of pixels of each class where `inside` is set.
std::array<int, kNumClasses> CountClasses(const cv::Mat1b& mask, const cv::Mat1b& inside) {
  std::array<int, kNumClasses> counts{};
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (inside(y, x) != 0 && mask(y, x) < kNumClasses) ++counts[mask(y, x)];
    }
  }
  return counts;
}

int MajorityClass(const std::array<int, kNumClasses>& counts, double min_labelled_ratio) {
  const int num_pixels = std::accumulate(counts.begin(), counts.end(), 0);
  const int num_labelled = num_pixels - counts[kUnlabelledClass];
  if (num_labelled == 0 || num_labelled < min_labelled_ratio * num_pixels) return kUnlabelledClass;
  return static_cast<int>(std::max_element(counts.begin() + 1, counts.end()) - counts.begin());
}

bool TellsGrass(int surface_class) {
  return surface_class != kUnlabelledClass && surface_class != kDormantGrassClass;
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

std::vector<Variation> Variations(int num_copies, uint64_t seed) {
  std::mt19937_64 generator(seed);
  // In [-1, 1]. The standard library's distributions differ between implementations.
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
                              const SegmentationOptions& options,
                              double min_labelled_ratio) {
  LabelledRegions regions;
  regions.segments =
      SegmentFrame(photograph.image, photograph.camera, photograph.height_above_ground, options);
  regions.mask = MaskAt(photograph.mask, regions.segments.image.size());
  for (const Segment& segment : regions.segments.segments) {
    const cv::Mat1b inside = regions.segments.labels == segment.label;
    regions.classes.push_back(
        MajorityClass(CountClasses(regions.mask, inside), min_labelled_ratio));
  }
  return regions;
}

LabelledRegions CutVaried(const LabelledPhotograph& photograph,
                          const Variation& variation,
                          double min_labelled_ratio) {
  SegmentationOptions options;
  options.ground_sampling_distance_m *= variation.sampling_ratio;
  options.detail_sampling_distance_m *= variation.sampling_ratio;
  options.min_region_area_m2 = kMinTrainingAreaM2;
  LabelledPhotograph varied = photograph;
  varied.image = Recoloured(photograph.image, variation);
  LabelledRegions regions = CutPhotograph(varied, options, min_labelled_ratio);
  if (variation.noise_sd_grey > 0.0) {
    regions.segments.detail_image = WithNoise(regions.segments.detail_image, variation);
  }
  regions.segments.detail_sampling_distance_m *= variation.told_sampling_ratio;
  return regions;
}

std::vector<TrainingSample> RegionSamples(const LabelledRegions& regions, FeatureSet feature_set) {
  const cv::Mat3b detail = ImageForFeatures(regions.segments.detail_image, feature_set);
  std::vector<TrainingSample> samples;
  for (size_t i = 0; i < regions.classes.size(); ++i) {
    if (!TellsGrass(regions.classes[i])) continue;
    TrainingSample sample;
    const cv::Mat1b inside =
        MaskAt(regions.segments.labels == regions.segments.segments[i].label, detail.size());
    sample.features =
        RegionFeatures(detail, inside, regions.segments.detail_sampling_distance_m, feature_set);
    sample.is_grass = regions.classes[i] == kGrassClass;
    samples.push_back(std::move(sample));
  }
  return samples;
}

std::vector<TrainingSample> TileSamples(const LabelledRegions& regions,
                                        FeatureSet feature_set,
                                        double tile_m) {
  const cv::Mat3b detail = ImageForFeatures(regions.segments.detail_image, feature_set);
  const cv::Mat1b mask = MaskAt(regions.mask, detail.size());
  const double ground_sampling = regions.segments.detail_sampling_distance_m;
  const int side = std::max(kMinTileSidePx, cvRound(tile_m / ground_sampling));
  std::vector<TrainingSample> samples;
  for (int y = 0; y + side <= mask.rows; y += side) {
    for (int x = 0; x + side <= mask.cols; x += side) {
      const cv::Rect tile(x, y, side, side);
      const auto counts = CountClasses(mask(tile), cv::Mat1b(tile.size(), uint8_t{1}));
      const int surface_class = MajorityClass(counts, kMinTilePurity);
      if (!TellsGrass(surface_class) ||
          counts[static_cast<size_t>(surface_class)] < kMinTilePurity * tile.area()) {
        continue;
      }
      cv::Mat1b inside(mask.size(), uint8_t{0});
      inside(tile) = 255;
      TrainingSample sample;
      sample.features = RegionFeatures(detail, inside, ground_sampling, feature_set);
      sample.is_grass = surface_class == kGrassClass;
      samples.push_back(std::move(sample));
    }
  }
  return samples;
}

std::vector<TrainingSample> SamplesOf(const Photographs& photographs,
                                      FeatureSet feature_set,
                                      int num_copies,
                                      int seed) {
  std::vector<TrainingSample> samples;
  auto variation_seed = static_cast<uint64_t>(seed) * photographs.size();
  for (const LabelledPhotograph& photograph : photographs) {
    const std::vector<Variation> variations = Variations(num_copies, variation_seed++);
    for (size_t i = 0; i < variations.size(); ++i) {
      const LabelledRegions regions = CutVaried(photograph, variations[i], kMinLabelledRatio);
      for (const auto& some :
           {RegionSamples(regions, feature_set), TileSamples(regions, feature_set, kTileM)}) {
        for (TrainingSample sample : some) {
          sample.place = photograph.place;
          sample.is_augmented = i > 0;
          samples.push_back(std::move(sample));
        }
      }
    }
  }
  return samples;
}

}  // namespace freelsd
