#include "server/intake/odd_photographs.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace freelsd {
namespace {

// Below this number no photograph is the odd one.
constexpr size_t kMinNumPhotos = 3;
// Lenses whose focal lengths differ by less than this ratio count as one.
constexpr double kSameLens = 1.05;
// No survey aircraft flies or climbs faster. Shorter jumps are noise of receivers.
constexpr double kMaxSpeedMps = 70.0, kMinJumpM = 500.0;
constexpr double kMaxClimbMps = 25.0, kMinClimbM = 120.0;
// Of photographs without times: in steps between photographs.
constexpr double kMaxNumSteps = 20.0;
// Largest share of photographs that are odd ones, where no speed proves it.
constexpr double kMaxOddRatio = 0.2;
// Heights above take-off of one flight have one take-off.
constexpr double kMaxTakeOffErrorM = 150.0;
// Sines: of an axis that counts as level, and of the least dive that no aircraft flies.
constexpr double kLevel = 0.17, kDive = 0.7;
constexpr double kHorizonRatio = 0.95;

std::string Count(size_t number, const std::string& noun) {
  return std::to_string(number) + " " + noun + (number == 1 ? "" : "s");
}

std::string Kilometres(double metres) {
  const auto tenths = std::lround(metres / 100.0);
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " km";
}

bool IsUsable(const BatchPhoto& photo) {
  return photo.image.image && photo.meta.position && photo.image.reason.empty();
}

void LeaveOut(BatchPhoto& photo, const std::string& why) {
  photo.image.code = "OddPhotograph";
  photo.image.reason = why;
}

std::vector<size_t> UsableOf(const std::vector<BatchPhoto>& photos) {
  std::vector<size_t> usable;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (IsUsable(photos[i])) usable.push_back(i);
  }
  return usable;
}

// --- One camera ---

struct Lens {
  int width_px = 0;
  int height_px = 0;
  std::string name;
  std::optional<double> focal_px;
  std::vector<size_t> photos;

  std::string Text() const {
    const std::string size = std::to_string(width_px) + "x" + std::to_string(height_px);
    const std::string focal =
        focal_px ? ", " + std::to_string(std::lround(*focal_px)) + " px focal length" : "";
    return (name.empty() ? "" : name + ", ") + size + focal;
  }
};

Lens LensOf(const CheckedImage& image) {
  const ImageTags& tags = image.tags;
  Lens lens{image.header.width_px, image.header.height_px, tags.camera_name, std::nullopt, {}};
  if (tags.camera) lens.focal_px = tags.camera->fx_px;
  return lens;
}

bool IsSame(const Lens& a, const Lens& b) {
  if (a.width_px != b.width_px || a.height_px != b.height_px || a.name != b.name) return false;
  if (!a.focal_px || !b.focal_px) return true;
  return std::max(*a.focal_px, *b.focal_px) < kSameLens * std::min(*a.focal_px, *b.focal_px);
}

// Pixels on the ground that a camera's photographs show together: many photographs, many pixels,
// wide lens.
double WorthOf(const Lens& lens) {
  const double pixels = static_cast<double>(lens.width_px) * lens.height_px;
  const double focal_px = lens.focal_px.value_or(20.0 * lens.width_px);
  return static_cast<double>(lens.photos.size()) * pixels * pixels / (focal_px * focal_px);
}

std::vector<Lens> LensesOf(const std::vector<BatchPhoto>& photos) {
  std::vector<Lens> lenses;
  for (const size_t i : UsableOf(photos)) {
    const Lens lens = LensOf(*photos[i].image.image);
    auto same = std::find_if(
        lenses.begin(), lenses.end(), [&lens](const Lens& each) { return IsSame(each, lens); });
    if (same == lenses.end()) same = lenses.insert(same, lens);
    same->photos.push_back(i);
  }
  return lenses;
}

ComparedPhotos WithOneCamera(ComparedPhotos compared) {
  const std::vector<Lens> lenses = LensesOf(compared.photos);
  if (lenses.size() < 2) return compared;
  const Lens& used =
      *std::max_element(lenses.begin(), lenses.end(), [](const Lens& a, const Lens& b) {
        return WorthOf(a) < WorthOf(b);
      });
  for (const Lens& lens : lenses) {
    if (&lens == &used) continue;
    const std::string why = "of another camera (" + lens.Text() + "); the flight's is " +
                            used.Text() + ", and a flight has only one";
    for (const size_t i : lens.photos) LeaveOut(compared.photos[i], "the photograph is " + why);
    compared.warnings.push_back(Count(lens.photos.size(), "photograph") + " left out: " + why);
  }
  return compared;
}

// --- One flight ---

double MetresBetween(const GeoPoint& a, const GeoPoint& b) {
  return LocalFrame(a).WorldFromGeo(b).norm();
}

// True if no aircraft gets from one photograph to the other.
bool IsJump(const FrameMeta& a, const FrameMeta& b, double typical_step_m) {
  const double distance_m = MetresBetween(*a.position, *b.position);
  const double climb_m = std::abs(a.position->altitude_m - b.position->altitude_m);
  if (distance_m <= kMinJumpM && climb_m <= kMinClimbM) return false;
  if (!a.timestamp_us || !b.timestamp_us) {
    return climb_m > kMinClimbM || distance_m > kMaxNumSteps * typical_step_m;
  }
  const double seconds =
      std::max(1.0, 1e-6 * std::abs(static_cast<double>(*a.timestamp_us - *b.timestamp_us)));
  return (distance_m > kMinJumpM && distance_m > kMaxSpeedMps * seconds) ||
         (climb_m > kMinClimbM && climb_m > kMaxClimbMps * seconds);
}

double TypicalStep(const std::vector<BatchPhoto>& photos, const std::vector<size_t>& usable) {
  std::vector<double> steps_m;
  for (size_t i = 1; i < usable.size(); ++i) {
    steps_m.push_back(
        MetresBetween(*photos[usable[i - 1]].meta.position, *photos[usable[i]].meta.position));
  }
  const auto middle = steps_m.begin() + static_cast<std::ptrdiff_t>(steps_m.size() / 2);
  std::nth_element(steps_m.begin(), middle, steps_m.end());
  return *middle;
}

// Photographs that one aircraft can have taken on one way, the largest group first.
std::vector<std::vector<size_t>> WaysOf(const std::vector<BatchPhoto>& photos) {
  const std::vector<size_t> usable = UsableOf(photos);
  const double step_m = TypicalStep(photos, usable);
  std::vector<std::vector<size_t>> ways;
  for (const size_t i : usable) {
    const auto way = std::find_if(ways.begin(), ways.end(), [&](const auto& each) {
      return !IsJump(photos[each.back()].meta, photos[i].meta, step_m);
    });
    if (way == ways.end()) {
      ways.push_back({i});
    } else {
      way->push_back(i);
    }
  }
  std::stable_sort(
      ways.begin(), ways.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return ways;
}

std::string OddPlace(const BatchPhoto& odd, const BatchPhoto& other) {
  const GeoPoint &place = *odd.meta.position, &usual = *other.meta.position;
  const double climb_m = place.altitude_m - usual.altitude_m;
  const double distance_m = MetresBetween(usual, place);
  if (distance_m > 2.0 * std::abs(climb_m)) {
    return "its position is " + Kilometres(distance_m) + " from the other photographs";
  }
  return "its altitude of " + std::to_string(std::lround(place.altitude_m)) + " m is " +
         std::to_string(std::lround(std::abs(climb_m))) + " m from the other photographs'";
}

ComparedPhotos OnOneWay(ComparedPhotos compared) {
  std::vector<BatchPhoto>& photos = compared.photos;
  if (UsableOf(photos).size() < kMinNumPhotos) return compared;
  const std::vector<std::vector<size_t>> ways = WaysOf(photos);
  const std::vector<size_t>& usual = ways[0];
  const auto num_usable = static_cast<double>(UsableOf(photos).size());
  for (size_t way = 1; way < ways.size(); ++way) {
    const auto num_odd = static_cast<double>(ways[way].size());
    const bool are_timed = std::all_of(ways[way].begin(), ways[way].end(), [&](size_t i) {
      return photos[i].meta.timestamp_us.has_value();
    });
    const bool is_odd = 2 * usual.size() > static_cast<size_t>(num_usable) &&
                        (are_timed || num_odd <= std::max(2.0, kMaxOddRatio * num_usable));
    for (const size_t i : ways[way]) {
      const std::string why = OddPlace(photos[i], photos[usual[0]]);
      compared.warnings.push_back(photos[i].image.id + ": " + why +
                                  (is_odd ? ": it is left out" : ", yet it is used"));
      if (is_odd) LeaveOut(photos[i], why + ", where no aircraft flies in the time: a wrong fix");
    }
  }
  return compared;
}

// --- Heights ---

ComparedPhotos WithOneTakeOff(ComparedPhotos compared) {
  const auto take_off_m = [](const BatchPhoto& photo) {
    return photo.tags.position->altitude_m - *photo.tags.height_above_ground_m;
  };
  std::vector<double> take_offs_m;
  std::vector<BatchPhoto*> tagged;
  for (const size_t i : UsableOf(compared.photos)) {
    BatchPhoto& photo = compared.photos[i];
    if (!photo.tags.position || !photo.tags.height_above_ground_m) continue;
    tagged.push_back(&photo);
    take_offs_m.push_back(take_off_m(photo));
  }
  if (tagged.size() <= kMinNumPhotos) return compared;
  const auto middle = take_offs_m.begin() + static_cast<std::ptrdiff_t>(take_offs_m.size() / 2);
  std::nth_element(take_offs_m.begin(), middle, take_offs_m.end());
  for (BatchPhoto* const photo : tagged) {
    if (std::abs(take_off_m(*photo) - *middle) <= kMaxTakeOffErrorM) continue;
    compared.warnings.push_back(photo->image.id +
                                ": its height above take-off does not fit its altitude and the "
                                "other photographs: it is not used");
    photo->tags.height_above_ground_m.reset();
  }
  return compared;
}

// --- Angles ---

// Positive where an axis of camera or aircraft looks down.
double DownOf(const Eigen::Quaterniond& ned_from_x, const Eigen::Vector3d& axis) {
  return (ned_from_x * axis).z();
}

bool HasAngles(const FrameMeta& meta) { return meta.ned_from_camera || meta.ned_from_body; }

// Share of the photographs with angles whose angles, the client's or else the tags', are like that.
double RatioOf(const std::vector<BatchPhoto>& photos,
               const std::function<bool(const FrameMeta&)>& is_it) {
  size_t num_angles = 0, num_it = 0;
  for (const size_t i : UsableOf(photos)) {
    const FrameMeta& meta = HasAngles(photos[i].given) ? photos[i].given : photos[i].tags;
    if (!HasAngles(meta)) continue;
    ++num_angles;
    num_it += is_it(meta) ? 1 : 0;
  }
  if (num_angles < kMinNumPhotos) return 0.0;
  return static_cast<double>(num_it) / static_cast<double>(num_angles);
}

bool Dives(const FrameMeta& meta) {
  return !meta.ned_from_camera && meta.ned_from_body &&
         DownOf(*meta.ned_from_body, Eigen::Vector3d::UnitX()) > kDive;
}

bool LooksLevel(const FrameMeta& meta) {
  return DownOf(meta.ned_from_camera ? *meta.ned_from_camera : *meta.ned_from_body,
                Eigen::Vector3d::UnitZ()) < kLevel;
}

FrameMeta WithoutAngles(FrameMeta meta) {
  if (HasAngles(meta)) meta.attitude_sd_deg.reset();
  meta.ned_from_camera.reset();
  meta.ned_from_body.reset();
  return meta;
}

// Pitch -90 of an aircraft is a dive; of a camera, where 0 is the horizon, it is straight down.
FrameMeta AsOfCamera(FrameMeta meta) {
  if (meta.ned_from_camera || !meta.ned_from_body) return meta;
  // Right, down, ahead of a camera are y, z, x of the body.
  const Eigen::Quaterniond body_from_ahead_camera(0.5, 0.5, 0.5, 0.5);
  meta.ned_from_camera = *meta.ned_from_body * body_from_ahead_camera;
  meta.ned_from_body.reset();
  return meta;
}

ComparedPhotos WithAngles(ComparedPhotos compared,
                          const std::function<FrameMeta(FrameMeta)>& change,
                          const std::string& warning) {
  for (BatchPhoto& photo : compared.photos) {
    photo.given = change(std::move(photo.given));
    photo.tags = change(std::move(photo.tags));
  }
  if (!warning.empty()) compared.warnings.push_back(warning);
  return compared;
}

ComparedPhotos WithPlausibleAngles(ComparedPhotos compared, const PhotoRules& rules) {
  if (rules.angles == BatchAngles::kNone) return WithAngles(std::move(compared), WithoutAngles, "");
  if (rules.angles == BatchAngles::kGiven || rules.has_mounting) return compared;
  if (RatioOf(compared.photos, Dives) > 0.5) {
    compared = WithAngles(std::move(compared),
                          AsOfCamera,
                          "a pitch near -90 is no aircraft's: the angles are read as the camera's, "
                          "0 is the horizon; with angles=given they are used as they are");
  }
  if (RatioOf(compared.photos, LooksLevel) < kHorizonRatio) return compared;
  return WithAngles(std::move(compared),
                    WithoutAngles,
                    "with their angles all cameras would look at or above the horizon: the angles "
                    "are not used, and the attitudes are estimated from the photographs; with "
                    "angles=given they are used as they are");
}

}  // namespace

ComparedPhotos ComparePhotos(std::vector<BatchPhoto> photos, const PhotoRules& rules) {
  ComparedPhotos compared{std::move(photos), {}};
  if (!rules.has_camera) compared = WithOneCamera(std::move(compared));
  compared = WithOneTakeOff(OnOneWay(std::move(compared)));
  return WithPlausibleAngles(std::move(compared), rules);
}

}  // namespace freelsd
