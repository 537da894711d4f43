#include "tests/server/organisations/two_organisations.h"

#include <fstream>

#include "api/import/import.h"
#include "tests/server/meadow_map.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

void FillFlight(Storage& north) {
  FlightRow flight;
  flight.id = "north-flight";
  flight.name = "north-name";
  flight.request_json = ParseFlightRequest(R"({"name":"north-name"})").canonical_json;
  flight.created_at_us = 1600000000000000;
  north.flights.Insert(flight);
  const std::string image = NoiseImage(1);
  FrameRow frame;
  frame.flight_id = flight.id;
  frame.id = "north-frame";
  frame.sha256 = Sha256Hex(image);
  frame.meta_json = frame.tags_json = "{}";
  frame.resolved_json =
      R"({"timestamp_us":1600000000000000,)"
      R"("position":{"latitude_deg":47.0,"longitude_deg":8.0,"altitude_m":600.0}})";
  frame.state = FrameState::kProcessed;
  JobRow job;
  job.id = "north-job";
  job.kind = "finish";
  job.flight_id = flight.id;
  job.state = JobState::kDone;
  north.images.Write(frame.sha256, image);
  north.frames.Insert(flight.id, {frame}, job, {});
  north.frames.SetState(flight.id, frame.id, FrameState::kProcessed, "");
  north.telemetry.Put(flight.id,
                      {{TelemetryKind::kPosition, 1600000000000000, {47.0, 8.0, 600.0, 1.0}}});
  north.flights.ReplaceRegions(
      flight.id,
      {{1,
        R"({"type":"Feature","geometry":{"type":"Point","coordinates":[8,47]},"properties":{"id":1}})",
        R"({"region_id":1,"history":[]})"}});
}

void FillGround(Storage& north) {
  const FlightMapRow map =
      StageMeadowMap(north, Meadow(), "north-flight", 1600000000000000, PhotoLattice{1.0, 512, 1});
  PutMeadowPicture(north, map);
  SiteRow site = SiteOnMap(map);
  site.id = "north-site";
  site.feature_json.replace(site.feature_json.find("f-r1"), 4, site.id);
  north.sites.PutEvaluation({{site}, {}, {map.id}, {}}, {});
  SiteRow own = MeadowSite("amsl", 5000.0);
  own.id = "north-old";
  own.feature_json.replace(own.feature_json.find("f-r1"), 4, own.id);
  own.flight_id = "north-flight";
  PutOnMap(north, own, Meadow());
  ObstacleRow mast;
  mast.id = "north-mast";
  mast.feature_json =
      R"({"type":"Feature","id":"north-mast","geometry":{"type":"Point","coordinates":[8.1,47.1]},)"
      R"("properties":{"kind":"mast","height_m":80}})";
  mast.box = {8.1, 47.1, 8.1, 47.1};
  north.obstacles.Put({mast}, 0);
}

std::filesystem::path TokenFile(const std::filesystem::path& folder) {
  nlohmann::json tokens = nlohmann::json::array();
  for (const char* const name : {"north", "south"}) {
    tokens.push_back({{"sha256", Sha256Hex(std::string("token of ") + name)},
                      {"scopes", {"read", "ingest", "admin", "command"}},
                      {"organisation", name}});
  }
  std::filesystem::path file = folder / "tokens.json";
  std::ofstream(file) << tokens.dump();
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  return file;
}

}  // namespace

TwoOrganisations::TwoOrganisations(const std::function<void(Config& config)>& change)
    : storage(std::make_unique<Storage>(place.OptionsOfOne())),
      north(storage->ForOrganisation("north")) {
  FillFlight(*north);
  FillGround(*north);
  const StorageOptions options = place.OptionsOfOther();
  Config config = TestConfig(options.folder);
  config.database = options.database_url;
  config.images = options.images_folder;
  config.role = Role::kApi;
  config.token_file = TokenFile(options.images_folder);
  if (change) change(config);
  server = std::make_unique<TestServer>(config);
}

httplib::Client TwoOrganisations::As(const std::string& organisation) const {
  httplib::Client client = server->Client();
  client.set_default_headers({{"Authorization", "Bearer token of " + organisation}});
  return client;
}

}  // namespace freelsd
