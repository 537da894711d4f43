// Readable poses that are probably wrong: swapped latitude and longitude, quaternions w last, poses
// shifted by one image. Each is a warning with a name; no pose is changed.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <GeographicLib/Geodesic.hpp>

#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

// Cosines of tilts: of cameras or aircraft that look down, and of others.
constexpr double kLooksDown = 0.5;
constexpr double kMinOddRatio = 0.25;
constexpr double kMinDownRatio = 0.95;
constexpr size_t kMinNumPoses = 4;
// No reference is this far away. A swap must also bring the place ten times nearer.
constexpr double kFarM = 20000.0;
// Geotags of photographs have smaller errors.
constexpr double kDisagreeM = 1000.0;
constexpr double kNearerRatio = 0.1;
// A shift by one image must halve the error, and the error must exceed these bounds.
constexpr double kShiftGain = 0.5;
constexpr double kMinShiftM = 3.0;
constexpr double kMinShiftS = 0.05;
// Largest angle between a plane's nose and its track in wind and in turns, for most of its steps.
// Shorter steps are ignored because the receiver's noise dominates their direction.
constexpr double kMaxCrabDeg = 45.0;
constexpr double kMinAlongRatio = 0.75;
constexpr double kMaxAstrayRatio = 0.35;
constexpr double kMinStepM = 5.0;

double MetresBetween(const GeoPoint& a, const GeoPoint& b) {
  double distance_m;
  GeographicLib::Geodesic::WGS84().Inverse(
      a.latitude_deg, a.longitude_deg, b.latitude_deg, b.longitude_deg, distance_m);
  return distance_m;
}

double DownOf(const Eigen::Quaterniond& ned_from_x) {
  return (ned_from_x * Eigen::Vector3d::UnitZ()).z();
}

double RatioOf(const std::vector<Eigen::Quaterniond>& attitudes,
               const std::function<bool(double)>& is_it) {
  const auto count = std::count_if(attitudes.begin(), attitudes.end(), [&](const auto& attitude) {
    return is_it(DownOf(attitude));
  });
  return static_cast<double>(count) / static_cast<double>(std::max<size_t>(1, attitudes.size()));
}

// The quaternion that the same four numbers give if the file has w last.
Eigen::Quaterniond WLast(const Eigen::Quaterniond& q) { return {q.z(), q.w(), q.x(), q.y()}; }

// Checks quaternions and gimbal angles only. Angles have no other order, but with valid angles no
// camera looks sideways, so they do not change the result.
bool IsWLastLikelyIn(const PoseFile& file) {
  std::vector<Eigen::Quaterniond> as_given, w_last;
  for (const auto& [image_id, meta] : file.poses) {
    if (!meta.ned_from_body) continue;
    as_given.push_back(*meta.ned_from_body);
    w_last.push_back(WLast(*meta.ned_from_body));
  }
  return IsWLastLikely(as_given, w_last);
}

using Tags = std::map<std::string, FrameMeta>;

// The image's geotag, or the flight's origin if the image has none.
std::optional<GeoPoint> ReferenceFor(const std::string& image_id,
                                     const Tags& tags,
                                     const SideContext& context) {
  const auto tag = tags.find(image_id);
  if (tag != tags.end() && tag->second.position) return tag->second.position;
  return context.origin;
}

GeoPoint Swapped(const GeoPoint& place) {
  return {place.longitude_deg, place.latitude_deg, place.altitude_m};
}

bool HasReference(const PoseFile& file, const Tags& tags, const SideContext& context) {
  return std::any_of(file.poses.begin(), file.poses.end(), [&](const auto& pose) {
    return ReferenceFor(pose.first, tags, context).has_value();
  });
}

bool AreSwapped(const PoseFile& file, const Tags& tags, const SideContext& context) {
  // Some poses may belong to images that are not in this batch.
  size_t num_compared = 0, num_swapped = 0;
  for (const auto& [image_id, meta] : file.poses) {
    const std::optional<GeoPoint> reference = ReferenceFor(image_id, tags, context);
    if (!meta.position || !reference) continue;
    ++num_compared;
    if (std::abs(meta.position->longitude_deg) > 90.0) continue;
    const double distance_m = MetresBetween(*meta.position, *reference);
    const double swapped_m = MetresBetween(Swapped(*meta.position), *reference);
    if (distance_m > kFarM && swapped_m < kNearerRatio * distance_m) {
      ++num_swapped;
    }
  }
  return num_swapped * 2 > num_compared;
}

// Poses with position and body attitude, ordered by time if all of them have a time.
std::vector<FrameMeta> InOrderOfFlight(const PoseFile& file) {
  std::vector<FrameMeta> flown;
  for (const auto& [image_id, meta] : file.poses) {
    const bool can_swap = meta.position && std::abs(meta.position->longitude_deg) <= 90.0;
    if (can_swap && meta.ned_from_body) flown.push_back(meta);
  }
  const bool have_times = std::all_of(
      flown.begin(), flown.end(), [](const auto& meta) { return meta.timestamp_us.has_value(); });
  if (have_times) {
    std::stable_sort(flown.begin(), flown.end(), [](const FrameMeta& a, const FrameMeta& b) {
      return *a.timestamp_us < *b.timestamp_us;
    });
  }
  return flown;
}

// Share of the steps between frames whose direction is that of the nose. Nothing if too few steps
// are long enough.
std::optional<double> AlongRatio(const std::vector<FrameMeta>& flown,
                                 const std::function<GeoPoint(const GeoPoint&)>& read) {
  size_t num_steps = 0, num_along = 0;
  for (size_t i = 1; i < flown.size(); ++i) {
    const GeoPoint from = read(*flown[i - 1].position), to = read(*flown[i].position);
    double distance_m, track_deg, arrival_deg;
    GeographicLib::Geodesic::WGS84().Inverse(from.latitude_deg,
                                             from.longitude_deg,
                                             to.latitude_deg,
                                             to.longitude_deg,
                                             distance_m,
                                             track_deg,
                                             arrival_deg);
    if (distance_m < kMinStepM) continue;
    const double yaw = EulerFromNedFromBody(*flown[i].ned_from_body).yaw;
    ++num_steps;
    num_along += std::abs(WrapAngle(RadFromDeg(track_deg) - yaw)) < RadFromDeg(kMaxCrabDeg);
  }
  if (num_steps < kMinNumPoses) return std::nullopt;
  return static_cast<double>(num_along) / static_cast<double>(num_steps);
}

// Used if nothing else gives the flight's position: planes fly where their nose points. A swap
// exchanges north and east.
bool FliesSwapped(const PoseFile& file) {
  const std::vector<FrameMeta> flown = InOrderOfFlight(file);
  const std::optional<double> as_given =
      AlongRatio(flown, [](const GeoPoint& place) { return place; });
  const std::optional<double> swapped = AlongRatio(flown, Swapped);
  return as_given && swapped && *as_given <= kMaxAstrayRatio && *swapped >= kMinAlongRatio;
}

// True if most poses whose image has a geotag are far from that geotag.
bool DisagreesWithGeotags(const PoseFile& file, const Tags& tags) {
  size_t num_compared = 0, num_far = 0;
  for (const auto& [image_id, meta] : file.poses) {
    const auto tag = tags.find(image_id);
    if (tag == tags.end() || !tag->second.position || !meta.position) continue;
    ++num_compared;
    num_far += MetresBetween(*meta.position, *tag->second.position) > kDisagreeM;
  }
  return num_far * 2 > num_compared;
}

// Mean of error(pose i + shift, image i) over the images that have all data. Nothing if too few
// do.
using Error = std::function<std::optional<double>(const FrameMeta& pose, const FrameMeta& tags)>;
std::optional<double> MeanError(const std::vector<std::pair<FrameMeta, FrameMeta>>& pairs,
                                int shift,
                                const Error& error) {
  double sum = 0.0;
  size_t num = 0;
  for (size_t i = 1; i + 1 < pairs.size(); ++i) {
    const FrameMeta& pose = pairs[i + static_cast<size_t>(shift)].first;
    const std::optional<double> one = error(pose, pairs[i].second);
    if (!one) continue;
    sum += *one;
    ++num;
  }
  if (num < kMinNumPoses) return std::nullopt;
  return sum / static_cast<double>(num);
}

bool FitsShifted(const std::vector<std::pair<FrameMeta, FrameMeta>>& pairs,
                 double min_error,
                 const Error& error) {
  const std::optional<double> as_given = MeanError(pairs, 0, error);
  if (!as_given || *as_given < min_error) return false;
  for (const int shift : {-1, 1}) {
    const std::optional<double> shifted = MeanError(pairs, shift, error);
    if (shifted && *shifted < kShiftGain * *as_given) return true;
  }
  return false;
}

// Compares the poses with the images' own geotags or times.
bool AreShifted(const PoseFile& file, const SideContext& context) {
  std::map<std::string, FrameMeta> poses(file.poses.begin(), file.poses.end());
  std::vector<std::pair<FrameMeta, FrameMeta>> pairs;
  for (const auto& [image_id, tags] : context.image_tags) {
    const auto pose = poses.find(image_id);
    if (pose != poses.end()) pairs.emplace_back(pose->second, tags);
  }
  const Error metres = [](const FrameMeta& pose, const FrameMeta& tags) -> std::optional<double> {
    if (!pose.position || !tags.position) return std::nullopt;
    return MetresBetween(*pose.position, *tags.position);
  };
  const Error seconds = [](const FrameMeta& pose, const FrameMeta& tags) -> std::optional<double> {
    if (!pose.timestamp_us || !tags.timestamp_us) return std::nullopt;
    return 1e-6 * std::abs(static_cast<double>(*pose.timestamp_us - *tags.timestamp_us));
  };
  return FitsShifted(pairs, kMinShiftM, metres) || FitsShifted(pairs, kMinShiftS, seconds);
}

}  // namespace

bool IsWLastLikely(const std::vector<Eigen::Quaterniond>& ned_from_x,
                   const std::vector<Eigen::Quaterniond>& ned_from_x_w_last) {
  if (ned_from_x.size() < kMinNumPoses) return false;
  const auto is_odd = [](double down) { return down < kLooksDown; };
  const auto is_down = [](double down) { return down >= kLooksDown; };
  return RatioOf(ned_from_x, is_odd) >= kMinOddRatio &&
         RatioOf(ned_from_x_w_last, is_down) >= kMinDownRatio;
}

std::vector<std::string> SuspicionsOf(const PoseFile& file, const SideContext& context) {
  const Tags tags(context.image_tags.begin(), context.image_tags.end());
  std::vector<std::string> warnings;
  if (AreSwapped(file, tags, context)) {
    warnings.emplace_back(
        "SwappedLatitudeLongitude: with latitude and longitude swapped the poses are where the "
        "images' geotags or the flight's origin are");
  } else if (!HasReference(file, tags, context) && FliesSwapped(file)) {
    warnings.emplace_back(
        "SwappedLatitudeLongitude: the craft flies where its yaw points only if latitude and "
        "longitude are swapped; they are used as given");
  }
  if (DisagreesWithGeotags(file, tags)) {
    warnings.emplace_back(
        "GeotagsDisagree: most poses are more than a kilometre from where the images' own geotags "
        "say; the poses are used");
  }
  if (IsWLastLikelyIn(file)) {
    warnings.emplace_back(
        "QuaternionOrder: the craft flies level only if the quaternions are read w last; they are "
        "read w first");
  }
  if (AreShifted(file, context)) {
    warnings.emplace_back(
        "ShiftedPoses: shifted by one image the poses fit the images' own tags much better");
  }
  return warnings;
}

}  // namespace freelsd
