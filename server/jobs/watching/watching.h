// Compares new photographs with the stored strips that they show. What stands on a strip and did
// not before is stored as an obstacle that expires: recall then ranks the site last.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/tracks/tracks.h"
#include "engine/watch/watch.h"
#include "server/jobs/service.h"

namespace freelsd {

struct StripWatchingOptions {
  WatchOptions watch;
  // What was seen on a strip counts for this time. Older photographs are not compared.
  double thing_lifetime_s = 600.0;
  // Photographs taken so soon after the stored picture belong to it.
  double min_age_s = 60.0;
  // Strips compared with one photograph, the nearest to its middle.
  size_t max_num_strips = 2;
  // The obstacle reaches so far above the strip's highest ground.
  double thing_height_m = 5.0;
};

// A photograph as the frontend has placed it.
struct PlacedPhoto {
  std::string flight_id;
  std::string frame_id;
  // When it was taken, microseconds since 1970.
  int64_t taken_at_us = 0;
  Camera camera;
  Rigid3d world_from_camera;
  GeoPoint origin;
  std::string altitude_datum;
};

// Not thread-safe.
class StripWatching {
 public:
  explicit StripWatching(Service& service, const StripWatchingOptions& options = {});
  ~StripWatching();

  // `image` is called if the photograph shows a stored strip, and may return an empty one. Errors
  // are logged: a flight goes on without the comparison.
  void Look(const PlacedPhoto& photo, const std::function<cv::Mat()>& image);
  void Forget(const std::string& flight_id);

 private:
  struct WatchedStrip;
  struct Watch;

  std::vector<std::shared_ptr<const WatchedStrip>> StripsIn(const PlacedPhoto& photo);
  void Compare(const PlacedPhoto& photo, const cv::Mat& image, const WatchedStrip& strip);
  void Tell(const PlacedPhoto& photo,
            const WatchedStrip& strip,
            const StripWatch::Report& report,
            Watch& watch);
  std::shared_ptr<const WatchedStrip> StripOf(const RecallRow& row);
  nlohmann::json AlternateTo(const std::string& flight_id, const std::string& site_id);

  Service& service_;
  StripWatchingOptions options_;
  // By flight and site.
  std::map<std::pair<std::string, std::string>, Watch> watches_;
  // Those that were compared last. Null: the site has no picture or no roll.
  struct KeptStrip {
    int64_t updated_at_us = 0;
    std::shared_ptr<const WatchedStrip> strip;
  };
  std::map<std::string, KeptStrip> strips_;
};

}  // namespace freelsd
