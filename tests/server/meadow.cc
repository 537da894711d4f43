#include "tests/server/meadow.h"

#include <algorithm>

#include "tests/server/site_on_map.h"

namespace freelsd {

SiteMap Meadow() {
  constexpr int kNumCells = 600;
  SiteMap meadow;
  meadow.map.grid = {Eigen::Vector2d(-300, 300), 1.0, kNumCells, kNumCells};
  const cv::Size size(kNumCells, kNumCells);
  meadow.map.elevation = cv::Mat1f(size, 0.0f);
  meadow.map.upper = cv::Mat1f(size, 0.1f);
  meadow.map.standard_deviation = cv::Mat1f(size, 0.1f);
  meadow.map.num_points = cv::Mat1f(size, 9.0f);
  meadow.layers.grid = meadow.map.grid;
  meadow.layers.slope = cv::Mat1f(size, 0.0f);
  meadow.layers.roughness = cv::Mat1f(size, 0.0f);
  meadow.layers.grass = cv::Mat1f(size, 0.99f);
  meadow.layers.kind = cv::Mat1b(size, LikelyKind{GroundKind::kGrass, 0.99f}.Packed());
  meadow.layers.hazard = cv::Mat1b(size, uchar{0});
  meadow.layers.distance = cv::Mat1f(size, 100.0f);
  return meadow;
}

SiteRow MeadowSite(const std::string& altitude_datum, double north_m) {
  const double latitude_deg = 47.0 + north_m / 111195.0;
  Replan replan;
  replan.flight = ParseFlightRequest(R"({"name":"meadow","aircraft":{"profile":"small"},)"
                                     R"("altitude_datum":")" +
                                     altitude_datum + "\"}");
  replan.origin = {latitude_deg, 8.0, 400.0};
  replan.request.footprint = {{-60, -60}, {60, -60}, {60, 60}, {-60, 60}};
  replan.request.area_m2 = 14400.0;
  replan.request.grade = 1.0;
  replan.request.num_observations = 20;
  SiteRow site;
  site.id = std::string("f-r1");
  site.flight_id = std::string("f");
  site.region_id = 1;
  site.latitude_deg = latitude_deg;
  site.longitude_deg = 8.0;
  site.feature_json = R"({"type":"Feature","geometry":{"type":"Point","coordinates":[8,47,400]},)"
                      R"("properties":{"id":"f-r1","verdict":"unverified","score":0.5}})";
  site.replan_json = ReplanJson(replan);
  site.seen_at_us = 1;
  site.recall =
      RecallData{false, 400.0, altitude_datum, 0.5, AircraftJson(replan.flight.aircraft).dump()};
  site.map_box = BoundingBox{7.996, latitude_deg - 0.003, 8.004, latitude_deg + 0.003};
  return site;
}

Standing SupersededBy(const std::string& site_id) {
  Standing standing;
  standing.superseded_by = site_id;
  standing.superseded_at_us = 1600000000000000;
  standing.superseded_reason = std::string("approach_blocked");
  standing.superseded_detail = std::string("the final is blocked 30 m before touchdown");
  return standing;
}

MeadowServer::MeadowServer(const std::function<void(Storage&)>& fill,
                           const std::function<void(Config&)>& change) {
  {
    Storage storage(StorageAt(folder.path() / "data"));
    PutOnMap(storage, MeadowSite(), Meadow());
    const std::string map_id = storage.sites.Find("f-r1")->map_id;
    SiteRow bare = MeadowSite();
    bare.id = std::string("f-r2");
    bare.longitude_deg = 9.0;
    bare.feature_json = R"({"type":"Feature","geometry":{"type":"Point","coordinates":[9,47,400]},)"
                        R"("properties":{"id":"f-r2","verdict":"rejected","score":0.1}})";
    bare.recall.reset();
    bare.map_box.reset();
    PutWithoutMap(storage, bare);
    if (fill) fill(storage);
    // A map that `fill` has replaced shows nothing any more.
    const std::vector<SiteRow> sites = storage.sites.List("f", std::nullopt);
    const bool is_needed = std::any_of(
        sites.begin(), sites.end(), [&](const SiteRow& site) { return site.map_id == map_id; });
    if (!is_needed) storage.sites.PutEvaluation({{}, {}, {}, {map_id}}, {});
  }
  Config config = TestConfig(folder.path() / "data");
  if (change) change(config);
  server = std::make_unique<TestServer>(config);
  client = std::make_unique<httplib::Client>(server->Client());
}

}  // namespace freelsd
