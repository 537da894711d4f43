#include "server/jobs/watching/watching.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/import/obstacles/obstacles.h"
#include "server/http/http.h"
#include "server/jobs/watching/stored_strip.h"

namespace freelsd {
namespace {

// Strips whose pictures stay in memory, 2 to 4 MB each.
constexpr size_t kMaxNumStripsKept = 16;
// No photograph of a small plane shows strips farther away.
constexpr double kMaxAwayM = 500.0;

struct StripLimits {
  double height_m = 0.0;
  int64_t expires_at_us = 0;
};

int64_t MicrosecondsOf(double seconds) { return static_cast<int64_t>(std::lround(seconds * 1e6)); }

std::string ObstacleIdOf(const std::string& site_id) {
  constexpr size_t kMaxIdBytes = 128;
  return ("strip-" + site_id).substr(0, kMaxIdBytes);
}

nlohmann::json ThingsJson(const std::vector<NewThing>& things, const LocalFrame& local_frame) {
  nlohmann::json told = nlohmann::json::array();
  for (const NewThing& thing : things) {
    const GeoPoint place = local_frame.GeoFromWorld(thing.place_in_world);
    told.push_back({{"latitude_deg", place.latitude_deg},
                    {"longitude_deg", place.longitude_deg},
                    {"length_m", thing.length_m},
                    {"width_m", thing.width_m},
                    {"cue", thing.cue == WatchCue::kColor ? "color" : "shade"}});
  }
  return told;
}

// An area in which nobody may be near the ground: recall ranks the site last, and warns.
ObstacleRow ObstacleOf(const StoredStrip& strip,
                       const std::string& id,
                       const PlacedPhoto& photo,
                       const StripLimits& limits) {
  GivenObstacle obstacle;
  obstacle.id = id;
  obstacle.kind = ObstacleKind::kNoFly;
  obstacle.name = "something new stands on this strip, seen " + Rfc3339(photo.taken_at_us);
  obstacle.points = strip.corners;
  for (GeoPoint& point : obstacle.points) point.altitude_m = std::nan("");
  obstacle.is_area = true;
  obstacle.ceiling_m = strip.highest_m + limits.height_m;
  obstacle.altitude_datum = strip.altitude_datum;
  obstacle.expires_at_us = limits.expires_at_us;
  return {id,
          ObstacleFeature(obstacle).dump(),
          BoxOfPoints(obstacle.points),
          obstacle.expires_at_us,
          NowUs()};
}

// The camera in the world of a map, whose altitudes may have another datum.
Rigid3d PoseIn(const StoredStrip& strip, const PlacedPhoto& photo) {
  GeoPoint place = LocalFrame(photo.origin).GeoFromWorld(photo.world_from_camera.translation);
  place.altitude_m -=
      DatumDifferenceOf(
          {photo.altitude_datum,
           photo.origin.latitude_deg,
           photo.origin.longitude_deg,
           photo.flight_id},
          {strip.altitude_datum, place.latitude_deg, place.longitude_deg, strip.flight_id})
          .subtracted_m;
  return {photo.world_from_camera.rotation, strip.local_frame.WorldFromGeo(place)};
}

}  // namespace

struct StripWatching::WatchedStrip {
  std::string site_id;
  StoredStrip stored;
};

struct StripWatching::Watch {
  StripWatch watch;
  // Until when the obstacle counts; nothing: none is stored.
  std::optional<int64_t> told_until_us;
  // Photographs that showed the things, the last ones.
  std::vector<std::string> frame_ids;
};

StripWatching::StripWatching(Service& service, const StripWatchingOptions& options)
    : service_(service), options_(options) {
  options_.watch.Check();
}

StripWatching::~StripWatching() = default;

void StripWatching::Look(const PlacedPhoto& photo, const std::function<cv::Mat()>& image) {
  if (NowUs() - photo.taken_at_us > MicrosecondsOf(options_.thing_lifetime_s)) return;
  try {
    const auto strips = StripsIn(photo);
    if (strips.empty()) return;
    const cv::Mat picture = image();
    if (picture.empty()) return;
    for (const auto& strip : strips) Compare(photo, picture, *strip);
  } catch (const std::exception& error) {
    spdlog::error("frame {} is not compared with stored strips: {}", photo.frame_id, error.what());
  }
}

void StripWatching::Forget(const std::string& flight_id) {
  std::erase_if(watches_, [&](const auto& each) { return each.first.first == flight_id; });
}

// Strips whose touchdown the photograph shows, and whose picture is older.
std::vector<std::shared_ptr<const StripWatching::WatchedStrip>> StripWatching::StripsIn(
    const PlacedPhoto& photo) {
  const LocalFrame frame(photo.origin);
  const GeoPoint place = frame.GeoFromWorld(photo.world_from_camera.translation);
  const Rigid3d camera_from_world = Inverse(photo.world_from_camera);
  const Eigen::Vector2d middle(0.5 * photo.camera.width_px, 0.5 * photo.camera.height_px);
  std::vector<std::pair<double, std::shared_ptr<const RecallRow>>> shown;
  for (const auto& row : service_.storage.sites.ListRecallable(BoxAroundPlace(place, kMaxAwayM))) {
    const int64_t pictured_us = SeenOf(*row).latest_us;
    if (photo.taken_at_us - pictured_us < MicrosecondsOf(options_.min_age_s)) continue;
    const GeoPoint touchdown{row->latitude_deg, row->longitude_deg, row->data.altitude_m};
    const auto pixel =
        photo.camera.ImageFromCamera(camera_from_world * frame.WorldFromGeo(touchdown));
    if (!pixel || !photo.camera.IsInside(*pixel)) continue;
    shown.emplace_back((*pixel - middle).norm(), row);
  }
  std::sort(shown.begin(), shown.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second->site_id) < std::pair(b.first, b.second->site_id);
  });
  std::vector<std::shared_ptr<const WatchedStrip>> strips;
  for (const auto& [distance, row] : shown) {
    if (strips.size() == options_.max_num_strips) break;
    if (auto strip = StripOf(*row)) strips.push_back(std::move(strip));
  }
  return strips;
}

std::shared_ptr<const StripWatching::WatchedStrip> StripWatching::StripOf(const RecallRow& row) {
  if (const auto known = strips_.find(row.site_id);
      known != strips_.end() && known->second.updated_at_us == row.updated_at_us) {
    return known->second.strip;
  }
  std::shared_ptr<const WatchedStrip> strip;
  if (const auto site = service_.storage.sites.Find(row.site_id)) {
    auto stored =
        StoredStripOf(service_.storage, service_.maps.flight_maps(), *site, options_.watch);
    if (stored) {
      strip = std::make_shared<const WatchedStrip>(WatchedStrip{row.site_id, *std::move(stored)});
    }
  }
  if (strips_.size() >= kMaxNumStripsKept) strips_.clear();
  strips_[row.site_id] = {row.updated_at_us, strip};
  return strip;
}

void StripWatching::Compare(const PlacedPhoto& photo,
                            const cv::Mat& image,
                            const WatchedStrip& strip) {
  const WatchedPhoto watched{image, photo.camera, PoseIn(strip.stored, photo), photo.taken_at_us};
  const StripLook look = LookAtStrip(strip.stored.picture, watched, options_.watch);
  const std::pair key(photo.flight_id, strip.site_id);
  auto watch = watches_.find(key);
  if (watch == watches_.end()) {
    watch = watches_.emplace(key, Watch{StripWatch(options_.watch), {}, {}}).first;
  }
  const StripWatch::Report report = watch->second.watch.Add(look);
  if (look.result == LookResult::kCompared) Tell(photo, strip, report, watch->second);
}

void StripWatching::Tell(const PlacedPhoto& photo,
                         const WatchedStrip& strip,
                         const StripWatch::Report& report,
                         Watch& watch) {
  const std::string obstacle_id = ObstacleIdOf(strip.site_id);
  nlohmann::json event{{"flight_id", photo.flight_id},
                       {"site_id", strip.site_id},
                       {"obstacle_id", obstacle_id},
                       {"seen_at", Rfc3339(photo.taken_at_us)}};
  if (!report.things.empty()) {
    watch.frame_ids.push_back(photo.frame_id);
    if (watch.frame_ids.size() > 2) watch.frame_ids.erase(watch.frame_ids.begin());
  }
  if (report.status == StripStatus::kOccupied) {
    const bool is_news = !watch.told_until_us;
    watch.told_until_us = photo.taken_at_us + MicrosecondsOf(options_.thing_lifetime_s);
    const StripLimits limits{options_.thing_height_m, *watch.told_until_us};
    service_.storage.obstacles.Put({ObstacleOf(strip.stored, obstacle_id, photo, limits)}, NowUs());
    service_.alternates.WakeAll();
    if (!is_news) return;
    event["state"] = "occupied";
    event["expires_at"] = Rfc3339(*watch.told_until_us);
    event["things"] = ThingsJson(report.things, strip.stored.local_frame);
    event["frames"] = watch.frame_ids;
    event["alternate"] = AlternateTo(photo.flight_id, strip.site_id);
  } else if (report.status == StripStatus::kNothingNew && watch.told_until_us) {
    watch.told_until_us.reset();
    watch.frame_ids.clear();
    service_.storage.obstacles.Delete(obstacle_id);
    service_.alternates.WakeAll();
    event["state"] = "free";
  } else {
    return;
  }
  service_.events.Publish("strip", photo.flight_id, event.dump());
}

// The best other site that the flight reaches without power; null without one.
nlohmann::json StripWatching::AlternateTo(const std::string& flight_id,
                                          const std::string& site_id) {
  const std::string text = service_.alternates.Answer(flight_id, 2);
  if (text.empty()) return nullptr;
  const nlohmann::json answer = nlohmann::json::parse(text);
  for (const nlohmann::json& site : answer.at("sites")) {
    if (site.at("site_id") != site_id && site.value("reachable", false)) return site.at("site_id");
  }
  return nullptr;
}

}  // namespace freelsd
