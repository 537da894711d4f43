#include "engine/watch/new_things.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace freelsd {
namespace {

// A thing that was there before and is gone leaves a change too, but stands out in the stored
// picture and not in the photograph.
constexpr double kLeastOwnContrast = 0.5;

struct Blob {
  std::vector<cv::Point> pixels;
  int num_on_strip = 0;
  // Something that is not shown lies beside it: nobody knows how far it reaches.
  bool is_cut = false;
  // Largest on the strip.
  float deviations = 0.0f;
  double change = 0.0;
  double seen_contrast = 0.0;
};

// Connected pixels whose change has this sign. They may reach beyond the strip.
std::vector<Blob> BlobsOfSign(const BandChange& band,
                              const StripChange& change,
                              double grow_deviations,
                              double least_change,
                              float sign) {
  const cv::Mat1b is_changed =
      (band.deviations >= grow_deviations) & (sign * band.change >= 0.5 * least_change);
  cv::Mat1b is_inside;
  cv::erode(change.is_shown, is_inside, cv::Mat());
  cv::Mat1i labels;
  const int num_labels = cv::connectedComponents(is_changed, labels, 8, CV_32S);
  std::vector<Blob> blobs(static_cast<size_t>(num_labels));
  for (int row = 0; row < labels.rows; ++row) {
    for (int col = 0; col < labels.cols; ++col) {
      if (labels(row, col) == 0) continue;
      Blob& blob = blobs[static_cast<size_t>(labels(row, col))];
      blob.pixels.emplace_back(col, row);
      blob.is_cut = blob.is_cut || is_inside(row, col) == 0;
      blob.change += band.change(row, col);
      blob.seen_contrast += band.seen_contrast(row, col);
      if (change.is_compared(row, col) == 0) continue;
      ++blob.num_on_strip;
      blob.deviations = std::max(blob.deviations, band.deviations(row, col));
    }
  }
  blobs.erase(blobs.begin());
  std::erase_if(blobs, [](const Blob& blob) { return blob.num_on_strip == 0; });
  return blobs;
}

// A bright thing and its shadow are two blobs: as one, their changes would cancel out.
std::vector<Blob> BlobsOf(const BandChange& band,
                          const StripChange& change,
                          double grow_deviations,
                          double least_change) {
  std::vector<Blob> blobs = BlobsOfSign(band, change, grow_deviations, least_change, 1.0f);
  std::vector<Blob> lower = BlobsOfSign(band, change, grow_deviations, least_change, -1.0f);
  std::move(lower.begin(), lower.end(), std::back_inserter(blobs));
  return blobs;
}

NewThing ThingOf(const Blob& blob, const StripCanvas& canvas, const StripGround& ground) {
  const double pixel_m = canvas.grid.cell_size_m;
  const cv::RotatedRect box = cv::minAreaRect(blob.pixels);
  NewThing thing;
  const Eigen::Vector2d place = canvas.PlaceAt(box.center.x, box.center.y);
  thing.place_in_world << place, ground.HeightAt(place);
  thing.length_m = pixel_m * (std::max(box.size.width, box.size.height) + 1.0);
  thing.width_m = pixel_m * (std::min(box.size.width, box.size.height) + 1.0);
  thing.area_m2 = pixel_m * pixel_m * static_cast<double>(blob.pixels.size());
  thing.deviations = blob.deviations;
  return thing;
}

bool StandsOut(const Blob& blob, double least_change) {
  const double size = std::abs(blob.change);
  const double own = blob.change > 0.0 ? blob.seen_contrast : -blob.seen_contrast;
  return size >= least_change * static_cast<double>(blob.pixels.size()) &&
         own >= kLeastOwnContrast * size;
}

// Other colours.
void AddColored(const StripChange& change,
                const StripCanvas& canvas,
                const StripGround& ground,
                const WatchOptions& options,
                NewThings& result) {
  for (const Blob& blob :
       BlobsOf(change.green, change, options.grow_deviations, options.min_green_change)) {
    NewThing thing = ThingOf(blob, canvas, ground);
    if (thing.length_m > options.max_size_m) {
      result.num_changed_ground += blob.num_on_strip;
      continue;
    }
    if (blob.deviations < options.min_deviations || thing.area_m2 < options.min_area_m2 ||
        !StandsOut(blob, options.min_green_change)) {
      continue;
    }
    thing.cue = WatchCue::kColor;
    result.things.push_back(thing);
  }
}

// A thing of another colour is darker or brighter too.
bool IsPartOf(const NewThing& part, const std::vector<NewThing>& things) {
  return std::any_of(things.begin(), things.end(), [&](const NewThing& thing) {
    const double distance = (part.place_in_world - thing.place_in_world).head<2>().norm();
    return thing.cue == WatchCue::kColor && distance <= 0.5 * (part.length_m + thing.length_m);
  });
}

// Darker or brighter, and narrow: a person, or a shadow that begins on the strip. Shadows of trees
// and clouds are wider, or come from beside the strip.
void AddShaded(const StripChange& change,
               const StripCanvas& canvas,
               const StripGround& ground,
               const WatchOptions& options,
               NewThings& result) {
  BandChange shade = change.brightness;
  cv::magnitude(change.brightness.deviations, change.green.deviations, shade.deviations);
  for (const Blob& blob :
       BlobsOf(shade, change, options.grow_deviations, options.min_shade_change)) {
    NewThing thing = ThingOf(blob, canvas, ground);
    const auto count = static_cast<double>(blob.pixels.size());
    if (blob.is_cut || thing.length_m > options.max_size_m ||
        thing.width_m > options.max_shade_width_m ||
        blob.num_on_strip < options.min_shade_on_strip_ratio * count ||
        blob.deviations < options.min_deviations || thing.area_m2 < options.min_area_m2 ||
        !StandsOut(blob, options.min_shade_change)) {
      continue;
    }
    if (IsPartOf(thing, result.things)) continue;
    thing.cue = WatchCue::kShade;
    result.things.push_back(thing);
  }
}

}  // namespace

NewThings ThingsIn(const StripChange& change,
                   const StripCanvas& canvas,
                   const StripGround& ground,
                   const WatchOptions& options) {
  NewThings result;
  AddColored(change, canvas, ground, options, result);
  AddShaded(change, canvas, ground, options, result);
  std::stable_sort(
      result.things.begin(), result.things.end(), [](const NewThing& a, const NewThing& b) {
        return a.deviations > b.deviations;
      });
  return result;
}

}  // namespace freelsd
