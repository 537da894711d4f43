#include "engine/watch/watch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "engine/watch/new_things.h"
#include "engine/watch/registration.h"
#include "engine/watch/strip_canvas.h"

namespace freelsd {
namespace {

constexpr double kSecondsPerMicrosecond = 1e-6;

void CheckRaster(const cv::Mat& raster, const Grid& grid, const char* name) {
  if (raster.size() == cv::Size(grid.num_cols, grid.num_rows)) return;
  throw std::invalid_argument(std::string("watch: ") + name + " has another size than its grid");
}

void CheckInput(const StripPicture& strip, const WatchedPhoto& photo) {
  CheckRaster(strip.picture, strip.grid, "picture");
  CheckRaster(strip.elevation, strip.ground_grid, "elevation");
  CheckRaster(strip.upper, strip.ground_grid, "upper");
  if (photo.image.type() != CV_8UC3 ||
      photo.image.size() != cv::Size(photo.camera.width_px, photo.camera.height_px)) {
    throw std::invalid_argument("watch: the image is not BGR of the camera's size");
  }
}

// Ground sampling of the strip where the photograph shows it best; nothing where it shows none.
std::optional<double> SamplingOf(const StripPicture& strip,
                                 const WatchedPhoto& photo,
                                 const StripGround& ground) {
  std::optional<double> finest;
  const auto visit = [&](const Eigen::Vector2d& place) {
    const auto sampling = SamplingAt(photo, ground, place);
    if (sampling) finest = std::min(finest.value_or(*sampling), *sampling);
  };
  visit(ExtentOf(strip).Middle());
  for (const Polygon& outline : strip.outlines) {
    for (const Eigen::Vector2d& corner : outline) visit(corner);
  }
  return finest;
}

double SecondsBetween(int64_t earlier_us, int64_t later_us) {
  return kSecondsPerMicrosecond * static_cast<double>(later_us - earlier_us);
}

}  // namespace

StripLook LookAtStrip(const StripPicture& strip,
                      const WatchedPhoto& photo,
                      const WatchOptions& options) {
  options.Check();
  CheckInput(strip, photo);
  StripLook look;
  look.timestamp_us = photo.timestamp_us;
  const StripGround ground(strip);
  if (ground.IsEmpty() || strip.outlines.empty()) return look;
  const std::optional<double> sampling = SamplingOf(strip, photo, ground);
  if (!sampling) return look;
  look.result = LookResult::kTooCoarse;
  if (*sampling > options.max_sampling_m) return look;
  look.result = LookResult::kNotShown;
  const StripCanvas canvas = MakeCanvas(strip, *sampling, options);
  const int num_strip = canvas.is_strip.empty() ? 0 : cv::countNonZero(canvas.is_strip);
  if (num_strip == 0) return look;
  look.result = LookResult::kNotRegistered;
  const auto registration = Register(photo, ground, canvas, options);
  if (!registration) return look;
  const ProjectedPhoto projected = Project(photo, ground, canvas, registration->displacement);
  const Eigen::Vector2d middle(0.5 * canvas.picture.cols, 0.5 * canvas.picture.rows);
  const Eigen::Vector2d moved = registration->displacement(middle.x(), middle.y());
  look.offset_in_world = canvas.grid.cell_size_m * Eigen::Vector2d(moved.x(), -moved.y());
  look.correlation = registration->correlation;
  const StripChange change =
      ChangeOf(canvas, projected, ComparableGround(canvas, ground, photo, options), options);
  NewThings found = ThingsIn(change, canvas, ground, options);
  look.compared_ratio =
      double(cv::countNonZero(change.is_compared) - found.num_changed_ground) / num_strip;
  look.things = std::move(found.things);
  const bool is_enough = look.compared_ratio >= options.min_compared_ratio;
  look.result = is_enough || !look.things.empty() ? LookResult::kCompared : LookResult::kNotShown;
  return look;
}

StripWatch::StripWatch(const WatchOptions& options) : options_(options) { options_.Check(); }

bool StripWatch::IsConfirmed(const NewThing& thing, int64_t timestamp_us) const {
  return std::any_of(looks_.begin(), looks_.end(), [&](const StripLook& earlier) {
    const double reach_m =
        options_.place_error_m +
        options_.max_speed_mps * SecondsBetween(earlier.timestamp_us, timestamp_us);
    return std::any_of(earlier.things.begin(), earlier.things.end(), [&](const NewThing& before) {
      const double distance_m = (before.place_in_world - thing.place_in_world).head<2>().norm();
      const double share = distance_m / options_.place_error_m;
      // Of false ones, the more are found the larger the area around.
      const double evidence = before.evidence + thing.evidence - std::log(1.0 + share * share);
      return distance_m <= reach_m && evidence >= options_.min_pair_evidence;
    });
  });
}

StripWatch::Report StripWatch::Add(const StripLook& look) {
  std::erase_if(looks_, [&](const StripLook& earlier) {
    return SecondsBetween(earlier.timestamp_us, look.timestamp_us) > options_.max_wait_s;
  });
  if (looks_.empty()) last_ = {};
  if (look.result != LookResult::kCompared) return last_;
  Report report;
  for (const NewThing& thing : look.things) {
    if (IsConfirmed(thing, look.timestamp_us)) report.things.push_back(thing);
  }
  report.status = StripStatus::kOccupied;
  if (report.things.empty()) {
    report.things = look.things;
    report.status = look.things.empty() ? StripStatus::kNothingNew : StripStatus::kSuspected;
  }
  looks_.push_back(look);
  last_ = report;
  return report;
}

}  // namespace freelsd
