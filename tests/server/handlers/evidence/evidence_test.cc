// Why a place of an evaluated flight is what it is: photographs, likelihood, cues and versions.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include "tests/server/openapi_check.h"
#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

std::string WhyAt(const nlohmann::json& position) {
  return "why?latitude_deg=" + position[1].dump() + "&longitude_deg=" + position[0].dump();
}

TEST_CASE("evidence: a cell of an evaluated flight tells what it was made of") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  httplib::Client& client = fresh.client;
  HoldAgainstContract(client);
  const std::string flight = PostSampleFlight(client, 0, kNumSampleFrames);
  REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
  const nlohmann::json sites = GetJson(client, "/v1/flights/" + flight + "/sites");
  REQUIRE_FALSE(sites["features"].empty());
  const nlohmann::json& site = sites["features"][0];
  const std::string query = WhyAt(site["geometry"]["coordinates"]);
  const nlohmann::json why = GetJson(client, "/v1/flights/" + flight + "/" + query);
  const nlohmann::json& evidence = why["evidence"];
  CAPTURE(why.dump());

  const nlohmann::json& patches = evidence["patches"];
  REQUIRE(patches.size() >= 2);
  CHECK(evidence["frames"].size() == patches.size());
  double sum = 0.0;
  for (const nlohmann::json& patch : patches) sum += patch["weight"].get<double>();
  CHECK(sum == doctest::Approx(1.0).epsilon(0.01));
  CHECK(patches[0]["weight"] >= patches[1]["weight"]);
  const auto picture = client.Get(patches[0]["url"].get<std::string>());
  REQUIRE(picture->status == 200);
  CHECK(picture->body.starts_with("\x89PNG"));
  CHECK_FALSE(evidence["context_frames"].is_null());

  const nlohmann::json& likelihood = evidence["height_likelihood"];
  REQUIRE(likelihood.is_object());
  const auto values = likelihood["log_likelihood"].get<std::vector<double>>();
  const auto best = std::max_element(values.begin(), values.end()) - values.begin();
  const double height_m = likelihood["height_m"][static_cast<size_t>(best)];
  CHECK(std::abs(height_m - evidence["height_m"].get<double>()) < 0.5);

  REQUIRE(evidence["cues"].is_array());
  const auto views = std::find_if(evidence["cues"].begin(),
                                  evidence["cues"].end(),
                                  [](const auto& cue) { return cue["cue"] == "views"; });
  REQUIRE(views != evidence["cues"].end());
  CHECK((*views)["log_odds"].is_number());
  CHECK(why["versions"]["program"] == GetJson(client, "/v1/info")["version"]);
  CHECK(why["versions"]["grass_model_sha256"].get<std::string>().size() == 64);
  CHECK(why["options"].is_object());

  const std::string id = site["properties"]["id"];
  const nlohmann::json of_site = GetJson(client, "/v1/sites/" + id + "/" + query);
  CHECK(of_site["evidence_digest"] == site["properties"]["evidence_digest"]);
  CHECK(of_site["evidence"]["patches"] == patches);

  const std::string frame = "/v1/flights/" + flight + "/frames/" +
                            patches[0]["frame_id"].get<std::string>() + "/patch.png?";
  CheckProblem(client.Get(frame + "x_px=1&y_px=1"), 400, "InvalidQuery");
  CheckProblem(client.Get(frame + "x_px=1&y_px=1&side_px=1000"), 422, "InvalidValue");
  CheckProblem(client.Get(frame + "x_px=90000&y_px=1&side_px=10"), 422, "InvalidValue");
  CheckProblem(
      client.Get("/v1/flights/" + flight + "/frames/none/patch.png?x_px=1&y_px=1&side_px=9"),
      404,
      "NoSuchFrame");
}

}  // namespace
}  // namespace freelsd
