// New photographs of a stored strip: what stands on it is told, and recall ranks the site last.
#include "server/jobs/watching/watching.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "server/base_map/base_map.h"
#include "server/http/http.h"
#include "server/recall/recall.h"
#include "tests/engine/watch/meadow_strip.h"
#include "tests/server/meadow.h"
#include "tests/server/meadow_map.h"

namespace freelsd {
namespace {

using watched::Grass;
using watched::With;

constexpr int64_t kSecondUs = 1000000;
constexpr int kTilePx = 512;
const GeoPoint kOrigin{47.0, 8.0, 400.0};
const watched::Look kWithCar = With(Grass, {8.0, 1.0}, {4.4, 1.8}, cv::Vec3d(200.0, 200.0, 200.0));

// 40 m long, 10 m wide, along the east.
std::string ApproachWithRoll() {
  nlohmann::json ring = nlohmann::json::array();
  const StripPicture strip = watched::StoredStrip(Grass);
  for (const Eigen::Vector2d& corner : strip.outlines.front()) {
    const GeoPoint point = LocalFrame(kOrigin).GeoFromWorld({corner.x(), corner.y(), 0.0});
    ring.push_back({point.longitude_deg, point.latitude_deg, point.altitude_m});
  }
  ring.push_back(ring.front());
  const nlohmann::json roll{
      {"type", "Feature"},
      {"geometry", {{"type", "Polygon"}, {"coordinates", nlohmann::json::array({ring})}}},
      {"properties", {{"kind", "ground_roll"}}}};
  return nlohmann::json{{"type", "FeatureCollection"}, {"features", {roll}}}.dump();
}

// The four tiles about the origin.
void PutPicture(Storage& storage, const std::string& map_id, const PhotoLattice& photo) {
  for (int row = -1; row <= 0; ++row) {
    for (int col = -1; col <= 0; ++col) {
      const Grid grid = photo.GridOf({0, row, col});
      cv::Mat4b picture(kTilePx, kTilePx);
      for (int v = 0; v < kTilePx; ++v) {
        for (int u = 0; u < kTilePx; ++u) {
          const cv::Vec3d color = Grass(grid.CellCenter(v, u));
          for (int i = 0; i < 3; ++i) picture(v, u)[i] = cv::saturate_cast<uint8_t>(color[i]);
          picture(v, u)[3] = 255;
        }
      }
      const std::string bytes = SerializePhotoTile(picture);
      const std::string sha256 = Sha256Hex(bytes);
      storage.images.Write(sha256, bytes);
      storage.maps.StageTiles(map_id, {}, {{{0, row, col}, sha256}});
    }
  }
}

// A service whose storage holds a strip that was photographed long ago.
struct WatchedService {
  TemporaryFolder folder;
  Config config = TestConfig(folder.path() / "data");
  Storage storage{StorageAt(folder.path() / "data")};
  EventLog events;
  MapCache maps{{size_t{64} << 20, size_t{64} << 20}};
  Intake intake{config, storage, events};
  Alternates alternates{storage, maps, events, 3};
  BaseMap base_map{config};
  Service service{intake, maps, alternates, base_map};
  StripWatching watching{service};
  int num_images = 0;

  WatchedService() {
    const PhotoLattice photo{watched::kPixelM, kTilePx, 1};
    const FlightMapRow map = StageMeadowMap(storage, Meadow(), "f", 1600000000000000, photo);
    PutPicture(storage, map.id, photo);
    SiteRow site = SiteOnMap(map);
    site.approach_json = ApproachWithRoll();
    storage.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  }

  // A photograph of the strip that shows `look`.
  void Photograph(const watched::Look& look, int64_t taken_at_us) {
    const WatchedPhoto photo = watched::PhotoOf(look, watched::AboveStrip(), taken_at_us);
    watching.Look({"g",
                   "p" + std::to_string(num_images),
                   taken_at_us,
                   photo.camera,
                   photo.world_from_camera,
                   kOrigin,
                   "amsl"},
                  [&] {
                    ++num_images;
                    return photo.image;
                  });
  }
  bool IsOccupied() const { return storage.obstacles.Find("strip-f-r1").has_value(); }
};

nlohmann::json Recall(const WatchedService& watched) {
  EmergencyRequest request;
  request.place = LocalFrame(kOrigin).GeoFromWorld({-150.0, 20.0, 120.0});
  request.altitude_datum = "amsl";
  request.wind_in_world = Eigen::Vector2d(-3.0, 0.0);
  request.aircraft = AircraftProfile("small");
  return RecallSites({watched.service.storage, watched.service.maps}, request);
}

TEST_CASE("watching: two photographs of a car on a strip are told, and it is free again later") {
  WatchedService watched;
  const int64_t now_us = NowUs();
  const int64_t first_event = watched.events.LastNumber();
  watched.Photograph(Grass, now_us - 20 * kSecondUs);
  watched.Photograph(kWithCar, now_us - 10 * kSecondUs);
  CHECK_FALSE(watched.IsOccupied());
  watched.Photograph(kWithCar, now_us - 9 * kSecondUs);
  REQUIRE(watched.IsOccupied());
  CHECK(watched.events.LastNumber() == first_event + 1);
  const std::optional<int64_t> expires_at_us =
      watched.storage.obstacles.Find("strip-f-r1")->expires_at_us;
  REQUIRE(expires_at_us);
  CHECK(*expires_at_us > now_us + 500 * kSecondUs);
  // The next photograph is no news.
  watched.Photograph(kWithCar, now_us - 8 * kSecondUs);
  CHECK(watched.events.LastNumber() == first_event + 1);
  CHECK(watched.num_images == 4);

  watched.Photograph(Grass, now_us - 1 * kSecondUs);
  watched.Photograph(Grass, now_us);
  CHECK_FALSE(watched.IsOccupied());
  CHECK(watched.events.LastNumber() == first_event + 2);
}

TEST_CASE("watching: recall still tells an occupied strip where nothing else is, with a warning") {
  WatchedService watched;
  const int64_t now_us = NowUs();
  const nlohmann::json before = Recall(watched);
  REQUIRE(before["sites"].size() == 1);
  for (const int64_t seconds : {2, 1}) watched.Photograph(kWithCar, now_us - seconds * kSecondUs);
  REQUIRE(watched.IsOccupied());
  const nlohmann::json after = Recall(watched);
  REQUIRE(after["sites"].size() == 1);
  CAPTURE(after.dump());
  CHECK(after["sites"][0]["airspaces"] == nlohmann::json{"strip-f-r1"});
}

TEST_CASE("watching: an old photograph, one of elsewhere and one without image are not compared") {
  WatchedService watched;
  watched.Photograph(kWithCar, NowUs() - 3600 * kSecondUs);
  CHECK(watched.num_images == 0);
  // Before the stored picture.
  watched.Photograph(kWithCar, 1500000000000000);
  CHECK(watched.num_images == 0);
  const WatchedPhoto photo = watched::PhotoOf(Grass, watched::AboveStrip());
  bool is_asked = false;
  PlacedPhoto elsewhere{"g", "p", NowUs(), photo.camera, photo.world_from_camera, kOrigin, "amsl"};
  elsewhere.origin.latitude_deg += 0.002;
  watched.watching.Look(elsewhere, [&] {
    is_asked = true;
    return cv::Mat();
  });
  CHECK_FALSE(is_asked);
  elsewhere.origin = kOrigin;
  watched.watching.Look(elsewhere, [&] {
    is_asked = true;
    return cv::Mat();
  });
  CHECK(is_asked);
  CHECK_FALSE(watched.IsOccupied());
}

}  // namespace
}  // namespace freelsd
