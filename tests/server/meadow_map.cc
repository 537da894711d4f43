#include "tests/server/meadow_map.h"

#include "api/import/import.h"
#include "server/jobs/staged_maps.h"

namespace freelsd {
namespace {

// Looks straight down from 100 m; shows 320 m by 640 m.
MapView ViewOf(const std::string& frame_id, double east_m) {
  MapView view;
  view.frame_id = frame_id;
  view.world_from_camera.rotation = Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
  view.world_from_camera.translation = {east_m, 0.0, 100.0};
  return view;
}

}  // namespace

FlightMapRow StageMeadowMap(Storage& storage,
                            const SiteMap& ground,
                            const std::string& flight_id,
                            int64_t seen_at_us,
                            const std::optional<PhotoLattice>& photo,
                            double longitude_deg) {
  Replan replan = ParseReplan(MeadowSite("amsl").replan_json);
  replan.origin.longitude_deg = longitude_deg;
  MapHead head;
  head.flight_json = replan.flight.canonical_json;
  head.origin = replan.origin;
  head.grid = ground.map.grid;
  head.camera.width_px = 320;
  head.camera.height_px = 640;
  head.camera.fx_px = head.camera.fy_px = 100.0;
  head.camera.cx_px = 159.5;
  head.camera.cy_px = 319.5;
  head.photo = photo;
  head.views = {ViewOf("left", -140.0), ViewOf("right", 140.0)};
  FlightMapRow row;
  row.id = storage.maps.NewId(flight_id);
  row.flight_id = flight_id;
  row.altitude_datum = "amsl";
  row.box = BoxOf(head.grid, LocalFrame(head.origin));
  row.updated_at_us = seen_at_us;
  row.seen_at_us = seen_at_us;
  StageMap(storage, row, head, {ground, cv::Mat1b(ground.map.elevation.size(), uchar{2})});
  return row;
}

SiteRow SiteOnMap(const FlightMapRow& map, double longitude_deg) {
  SiteRow site = MeadowSite("amsl");
  Replan replan = ParseReplan(site.replan_json);
  replan.origin.longitude_deg = longitude_deg;
  site.replan_json = ReplanJson(replan);
  site.longitude_deg = longitude_deg;
  site.map_box = BoxOf(Meadow().map.grid, LocalFrame(replan.origin));
  site.flight_id = map.flight_id;
  site.map_id = map.id;
  site.seen_at_us = map.seen_at_us;
  return site;
}

void PutMeadowPicture(Storage& storage, const FlightMapRow& map) {
  const std::string bytes = SerializePhotoTile(cv::Mat4b(512, 512, cv::Vec4b(60, 120, 80, 255)));
  const std::string sha256 = Sha256Hex(bytes);
  storage.images.Write(sha256, bytes);
  storage.maps.StageTiles(map.id, {}, {{{0, 0, 0}, sha256}});
}

void StoreMeadowMap(Storage& storage, const SiteMap& ground) {
  const FlightMapRow map = StageMeadowMap(storage, ground);
  storage.sites.PutEvaluation({{SiteOnMap(map)}, {}, {map.id}, {}}, {});
}

}  // namespace freelsd
