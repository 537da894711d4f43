// The maps of a flight over HTTP.
#include <doctest/doctest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "api/export/map/map.h"
#include "api/plan_json.h"
#include "tests/server/meadow_map.h"
#include "tests/server/openapi_check.h"

namespace freelsd {
namespace {

const std::string kMap = "/v1/flights/f/map";

// The meadow with a house, and a patch that nobody saw.
SiteMap MeadowWithHouse() {
  SiteMap meadow = Meadow();
  const cv::Rect house(330, 290, 8, 8), unseen(250, 240, 20, 20);
  meadow.map.upper(house).setTo(7.0f);
  meadow.layers.hazard(house).setTo(kHazard);
  for (cv::Mat1f* const raster : {&meadow.map.elevation,
                                  &meadow.map.upper,
                                  &meadow.map.num_points,
                                  &meadow.layers.slope,
                                  &meadow.layers.roughness}) {
    (*raster)(unseen).setTo(std::nanf(""));
  }
  meadow.layers.hazard(unseen).setTo(kUnseen);
  return meadow;
}

MeadowServer ServerWithMap() {
  return MeadowServer([](Storage& storage) { StoreMeadowMap(storage, MeadowWithHouse()); });
}

GeoPoint PlaceAt(double east_m, double north_m) {
  return LocalFrame(GeoPoint{47.0, 8.0, 400.0}).GeoFromWorld({east_m, north_m, 0.0});
}

std::string At(double east_m, double north_m) {
  const GeoPoint place = PlaceAt(east_m, north_m);
  return "latitude_deg=" + std::to_string(place.latitude_deg) +
         "&longitude_deg=" + std::to_string(place.longitude_deg);
}

cv::Mat4b TileOver(const MeadowServer& meadow,
                   const std::string& layer,
                   const GeoPoint& place,
                   int z) {
  const XyzTile tile = TileAt(place, z);
  const auto answer =
      meadow.client->Get(kMap + "/" + layer + "/" + std::to_string(tile.z) + "/" +
                         std::to_string(tile.x) + "/" + std::to_string(tile.y) + ".png");
  REQUIRE(answer);
  REQUIRE(answer->status == 200);
  CHECK(answer->get_header_value("Content-Type") == "image/png");
  cv::Mat decoded = cv::imdecode(std::vector<char>(answer->body.begin(), answer->body.end()),
                                 cv::IMREAD_UNCHANGED);
  cv::Mat4b picture;
  if (decoded.channels() == 4) return decoded;
  cv::cvtColor(decoded, picture, cv::COLOR_BGR2BGRA);
  return picture;
}

cv::Vec4b PixelAt(const MeadowServer& meadow,
                  const std::string& layer,
                  double east_m,
                  double north_m) {
  constexpr int kZoom = 19;
  const GeoPoint place = PlaceAt(east_m, north_m);
  const GeoBounds bounds = BoundsOf(TileAt(place, kZoom));
  const cv::Mat4b tile = TileOver(meadow, layer, place, kZoom);
  const double x = (place.longitude_deg - bounds.west_deg) / (bounds.east_deg - bounds.west_deg);
  const double y = (bounds.north_deg - place.latitude_deg) / (bounds.north_deg - bounds.south_deg);
  return tile(static_cast<int>(y * tile.rows), static_cast<int>(x * tile.cols));
}

TEST_CASE("flight map: its layers are listed with absolute addresses that work") {
  const MeadowServer meadow = ServerWithMap();
  HoldAgainstContract(*meadow.client);
  const nlohmann::json map = GetJson(*meadow.client, kMap);
  std::vector<std::string> names;
  for (const nlohmann::json& layer : map["layers"]) {
    names.push_back(layer["name"]);
    CHECK(layer["tilejson"] == "3.0.0");
    const std::string url = layer["tiles"][0];
    CHECK(url.starts_with("http://127.0.0.1"));
    CHECK(url.find("{z}/{x}/{y}") != std::string::npos);
    const std::string legend = layer["legend"];
    CHECK(meadow.client->Get(legend.substr(legend.find("/v1")))->status == 200);
  }
  for (const char* const name : {"hazard",
                                 "elevation",
                                 "slope",
                                 "roughness",
                                 "grass",
                                 "distance",
                                 "height_sd",
                                 "coverage",
                                 "risk",
                                 "kind"}) {
    CAPTURE(name);
    CHECK(std::find(names.begin(), names.end(), name) != names.end());
  }
}

TEST_CASE("flight map: a tile shows the house, the meadow and unseen ground where they are") {
  const MeadowServer meadow = ServerWithMap();
  const cv::Vec4b house = PixelAt(meadow, "hazard", 34.0, 6.0);
  const cv::Vec4b grass = PixelAt(meadow, "hazard", 60.0, -30.0);
  const cv::Vec4b unseen = PixelAt(meadow, "hazard", -40.0, 50.0);
  CHECK(house != grass);
  CHECK(unseen != grass);
  CHECK(unseen != house);
  CHECK(unseen[3] == 255);
  CHECK(PixelAt(meadow, "elevation", -40.0, 50.0)[3] == 0);
  CHECK(PixelAt(meadow, "elevation", 60.0, -30.0)[3] == 255);
  CHECK(PixelAt(meadow, "hazard", 310.0, 0.0)[3] == 0);
  // From far away a house is still no meadow.
  const cv::Mat4b far = TileOver(meadow, "hazard", PlaceAt(0.0, 0.0), 14);
  bool has_hazard = false;
  for (const cv::Vec4b& pixel : far) has_hazard = has_hazard || pixel == house;
  CHECK(has_hazard);
}

// From west to east over the meadow, 40 m south of the house, 15 m high.
void PutWire(const MeadowServer& meadow) {
  const auto at = [](double east_m) {
    const GeoPoint place = PlaceAt(east_m, -34.0);
    return nlohmann::json{place.longitude_deg, place.latitude_deg};
  };
  const nlohmann::json wire{
      {"type", "Feature"},
      {"geometry", {{"type", "LineString"}, {"coordinates", {at(-400.0), at(400.0)}}}},
      {"properties", {{"kind", "wire"}, {"height_m", 15.0}, {"position_sd_m", 1.0}}}};
  const auto put = meadow.client->Put("/v1/obstacles/w1", wire.dump(), "application/geo+json");
  REQUIRE(put->status == 201);
}

TEST_CASE("flight map: hazard and distance show entered obstacles as long as they are there") {
  const MeadowServer meadow = ServerWithMap();
  const auto etag = [&meadow] {
    const XyzTile tile = TileAt(PlaceAt(0, 0), 14);
    const std::string place = std::to_string(tile.x) + "/" + std::to_string(tile.y);
    return meadow.client->Get(kMap + "/hazard/14/" + place + ".png")->get_header_value("ETag");
  };
  const cv::Vec4b house = PixelAt(meadow, "hazard", 34.0, 6.0);
  const cv::Vec4b grass = PixelAt(meadow, "hazard", 60.0, -34.0);
  const cv::Vec4b far = PixelAt(meadow, "distance", 60.0, -50.0);
  const std::string tag = etag();
  PutWire(meadow);
  CHECK(PixelAt(meadow, "hazard", 60.0, -34.0) == house);
  CHECK(PixelAt(meadow, "hazard", 60.0, -50.0) == grass);
  CHECK(PixelAt(meadow, "distance", 60.0, -34.0) == PixelAt(meadow, "distance", 34.0, 6.0));
  CHECK(PixelAt(meadow, "distance", 60.0, -50.0) != far);
  // Unseen ground stays unseen.
  CHECK(PixelAt(meadow, "hazard", -40.0, 50.0) != house);
  CHECK(etag() != tag);
  REQUIRE(meadow.client->Delete("/v1/obstacles/w1")->status == 204);
  CHECK(PixelAt(meadow, "hazard", 60.0, -34.0) == grass);
  CHECK(PixelAt(meadow, "distance", 60.0, -50.0) == far);
  CHECK(etag() == tag);
}

TEST_CASE("site layers: hazard shows the obstacles that reject the site") {
  const MeadowServer meadow = ServerWithMap();
  const auto hazards = [&meadow](const std::string& ending) {
    const auto answer = meadow.client->Get("/v1/sites/f-r1/layers/hazard" + ending);
    REQUIRE(answer->status == 200);
    cv::Mat decoded = cv::imdecode(std::vector<char>(answer->body.begin(), answer->body.end()),
                                   ending == ".tif" ? cv::IMREAD_UNCHANGED : cv::IMREAD_COLOR);
    REQUIRE_FALSE(decoded.empty());
    return decoded;
  };
  const cv::Mat picture = hazards(".png"), values = hazards(".tif");
  PutWire(meadow);
  const cv::Mat3b changed = hazards(".png") != picture;
  int num_changed = 0;
  for (const cv::Vec3b& pixel : changed) num_changed += pixel != cv::Vec3b();
  // A line of some metres across all of the picture.
  CHECK(num_changed >= 3 * picture.cols);
  CHECK(num_changed <= 20 * picture.cols);
  CHECK(cv::countNonZero(hazards(".tif") == kHazard) >=
        cv::countNonZero(values == kHazard) + 3 * values.cols);
}

TEST_CASE("flight map: a client that has the tile gets 304, until the map changes") {
  const MeadowServer meadow = ServerWithMap();
  const XyzTile tile = TileAt(PlaceAt(0, 0), 17);
  const std::string path =
      kMap + "/hazard/17/" + std::to_string(tile.x) + "/" + std::to_string(tile.y) + ".png";
  const auto first = meadow.client->Get(path);
  REQUIRE(first->status == 200);
  const std::string tag = first->get_header_value("ETag");
  CHECK_FALSE(tag.empty());
  CHECK(first->get_header_value("Cache-Control").find("private") != std::string::npos);
  const auto again = meadow.client->Get(path, {{"If-None-Match", tag}});
  CHECK(again->status == 304);
  CHECK(again->body.empty());
  CHECK(meadow.client->Get(path, {{"If-None-Match", "\"other\""}})->status == 200);
}

TEST_CASE("flight map: what does not exist is said, and bad numbers are refused") {
  const MeadowServer meadow = ServerWithMap();
  HoldAgainstContract(*meadow.client);
  CHECK(meadow.client->Get("/v1/flights/none/map")->status == 404);
  CHECK(meadow.client->Get(kMap + "/none/1/0/0.png")->status == 404);
  CHECK(meadow.client->Get(kMap + "/hazard/1/0/0.jpg")->status == 404);
  CHECK(meadow.client->Get(kMap + "/hazard/1/2/0.png")->status == 422);
  CHECK(meadow.client->Get(kMap + "/hazard/99/0/0.png")->status == 422);
  CHECK(meadow.client->Get(kMap + "/hazard/x/0/0.png")->status == 422);
  CHECK(meadow.client->Get(kMap + "/hazard/1/-1/0.png")->status == 422);
  CHECK(meadow.client->Get(kMap + "/photo/1/0/0.png")->status == 404);
  CHECK(meadow.client->Get("/v1/flights/f/why?" + At(0, 5000))->status == 404);
}

TEST_CASE("flight map: GeoTIFF and KMZ are whole files") {
  const MeadowServer meadow = ServerWithMap();
  const auto tiff = meadow.client->Get(kMap + "/elevation.tif");
  REQUIRE(tiff->status == 200);
  CHECK(tiff->get_header_value("Content-Type") == "image/tiff");
  CHECK((tiff->body.starts_with("II*") || tiff->body.starts_with("II+")));
  CHECK(meadow.client->Get(kMap + "/hazard.tif")->status == 200);
  const auto kmz = meadow.client->Get(kMap + "/hazard.kmz");
  REQUIRE(kmz->status == 200);
  CHECK(kmz->body.starts_with("PK"));
}

// Before the start, the picture may be removed to free disk space.
enum class Picture { kKept, kRemoved };
MeadowServer ServerWithPicture(Picture picture) {
  return MeadowServer([picture](Storage& storage) {
    const FlightMapRow map =
        StageMeadowMap(storage, Meadow(), "f", 1600000000000000, PhotoLattice{1.0, 512, 1});
    PutMeadowPicture(storage, map);
    storage.sites.PutEvaluation({{SiteOnMap(map)}, {}, {map.id}, {}}, {});
    if (picture == Picture::kRemoved) storage.maps.RemovePhotoTiles("f");
  });
}

bool ListsPhoto(const MeadowServer& meadow) {
  const nlohmann::json layers = GetJson(*meadow.client, kMap)["layers"];
  return std::any_of(layers.begin(), layers.end(), [](const nlohmann::json& layer) {
    return layer["name"] == "photo";
  });
}

TEST_CASE("flight map: the layer photo has tiles of any zoom and a GeoTIFF") {
  const MeadowServer meadow = ServerWithPicture(Picture::kKept);
  HoldAgainstContract(*meadow.client);
  CHECK(ListsPhoto(meadow));
  const cv::Vec4b inside = PixelAt(meadow, "photo", 60.0, -30.0);
  CHECK(inside[3] == 255);
  CHECK(std::abs(inside[1] - 120) < 5);
  CHECK(PixelAt(meadow, "photo", -60.0, -30.0)[3] == 0);
  for (const int z : {0, 3, 9, 14}) TileOver(meadow, "photo", PlaceAt(100.0, -100.0), z);
  const auto tiff = meadow.client->Get(kMap + "/photo.tif");
  REQUIRE(tiff);
  CHECK(tiff->status == 200);
}

TEST_CASE("flight map: a picture that was removed to free disk space is no layer any more") {
  const MeadowServer before = ServerWithPicture(Picture::kKept);
  const MeadowServer after = ServerWithPicture(Picture::kRemoved);
  HoldAgainstContract(*after.client);
  CHECK_FALSE(ListsPhoto(after));
  const auto kept = before.client->Get(kMap + "/photo.kmz");
  REQUIRE(kept);
  CHECK(kept->status == 200);
  const httplib::Headers known{{"If-None-Match", kept->get_header_value("ETag")}};
  for (const char* const path : {"/photo.kmz", "/photo.tif", "/photo/17/0/0.png"}) {
    CAPTURE(path);
    CheckProblem(after.client->Get(kMap + path, known), 404, "NoMap");
  }
  CHECK(after.client->Get(kMap + "/hazard.kmz", known)->status == 200);
}

TEST_CASE("flight map: an error has no tag, is not to be kept, and is never 304") {
  const MeadowServer meadow = ServerWithMap();
  HoldAgainstContract(*meadow.client);
  const auto tiff = meadow.client->Get(kMap + "/hazard.tif");
  REQUIRE(tiff);
  const std::string tag = tiff->get_header_value("ETag");
  REQUIRE_FALSE(tag.empty());
  CHECK(meadow.client->Get(kMap + "/hazard.tif", {{"If-None-Match", tag}})->status == 304);
  // The meadow has no picture.
  for (const char* const path : {"/photo.tif", "/photo.kmz", "/photo/legend.png"}) {
    for (const std::string& known : {tag, std::string("*")}) {
      CAPTURE(path);
      const auto answer = meadow.client->Get(kMap + path, {{"If-None-Match", known}});
      CheckProblem(answer, 404, "NoMap");
      CHECK_FALSE(answer->has_header("ETag"));
      CHECK(answer->get_header_value_count("Cache-Control") == 1);
      CHECK(answer->get_header_value("Cache-Control") == "no-store");
    }
  }
}

TEST_CASE("flight map: why names the rule at any place, and the frames that show it") {
  const MeadowServer meadow = ServerWithMap();
  HoldAgainstContract(*meadow.client);
  const std::string wind = "&wind_east_mps=0&wind_north_mps=-4";
  const auto why = [&](double east_m, double north_m) {
    return GetJson(*meadow.client, "/v1/flights/f/why?" + At(east_m, north_m) + wind);
  };
  const nlohmann::json good = why(60.5, -60.5);
  CAPTURE(good.dump());
  CHECK(good["verdict"] == "landable");
  CHECK(good["evidence"]["frames"] == nlohmann::json{"right"});
  const nlohmann::json patch = good["evidence"]["patches"][0];
  CHECK(patch["frame_id"] == "right");
  // 79.5 m west and 60.5 m south of the middle of a pixel a metre wide, 159.5, 319.5.
  CHECK(patch["x_px"].get<double>() == doctest::Approx(80.0).epsilon(0.02));
  CHECK(patch["y_px"].get<double>() == doctest::Approx(380.0).epsilon(0.02));
  // The map stays when its flight is deleted, with its photographs.
  CheckProblem(meadow.client->Get(patch["url"].get<std::string>()), 404, "NoSuchFlight");
  CHECK(good["evidence"]["height_likelihood"].is_null());
  CHECK(good["evidence"]["context_frames"].is_null());
  CHECK(good["nearest_limit"]["margin"].get<double>() ==
        doctest::Approx(good["nearest_limit"]["limit"].get<double>() -
                        good["nearest_limit"]["value"].get<double>()));
  CHECK(good["nearest_limit"]["margin"].get<double>() > 0.0);
  CHECK(why(0.5, -60.5)["evidence"]["frames"] == nlohmann::json{"left", "right"});
  CHECK(why(-200.5, -60.5)["evidence"]["frames"] == nlohmann::json{"left"});
  CHECK(why(34.5, 5.5)["first_failed"] == "object");
  CHECK(why(-40.5, 50.5)["first_failed"] == "seen");
  // Far from any site of the flight.
  CHECK(why(150.5, 150.5)["first_failed"].is_null());
}

TEST_CASE("flight map: a landing is planned at any place, for any aircraft") {
  const MeadowServer meadow = ServerWithMap();
  HoldAgainstContract(*meadow.client);
  const std::string query =
      "/v1/flights/f/landing?" + At(80, -80) + "&wind_east_mps=0&wind_north_mps=-5";
  const nlohmann::json small = GetJson(*meadow.client, query);
  const nlohmann::json techpod = GetJson(*meadow.client, query + "&aircraft=techpod");
  CHECK(small["plan"]["verdict"] == "landable");
  CHECK(techpod["plan"]["aircraft"]["landing_airspeed_mps"] == 13);
  const auto nowhere = meadow.client->Get("/v1/flights/f/landing?" + At(299, 299) +
                                          "&wind_east_mps=0&wind_north_mps=14");
  CHECK(nowhere->status == 409);
}

TEST_CASE("flight map: a site is planned on its tiles as on the whole map in memory") {
  const MeadowServer meadow = ServerWithMap();
  const SiteMap house = MeadowWithHouse();
  const SiteMap rounded = Rounded(house.map, house.layers);
  const Replan replan = ParseReplan(MeadowSite("amsl").replan_json);
  const StoredMapPlanner whole(replan, replan.flight.aircraft, rounded);
  const FlightContext context{"f", "amsl", LocalFrame(replan.origin)};
  for (const Eigen::Vector2d& wind : {Eigen::Vector2d(0.0, -4.0), Eigen::Vector2d(3.0, 3.0)}) {
    CAPTURE(wind.x());
    const Plan plan = whole.planner.PlanFor(wind);
    REQUIRE(plan.approach);
    const nlohmann::json answer =
        GetJson(*meadow.client,
                "/v1/sites/f-r1/approach?wind_east_mps=" + std::to_string(wind.x()) +
                    "&wind_north_mps=" + std::to_string(wind.y()));
    CHECK(answer["features"] == ApproachJson(plan, context)["features"]);
    CHECK(answer["plan"]["verdict"] == NameOf(plan.verdict));
  }
}

TEST_CASE("flight map: it outlives its flight, but not its sites") {
  const MeadowServer meadow = ServerWithMap();
  // Flight "f" has no row, as if it were deleted.
  CHECK(meadow.client->Get("/v1/flights/f")->status == 404);
  CHECK(meadow.client->Get(kMap)->status == 200);
}

}  // namespace
}  // namespace freelsd
