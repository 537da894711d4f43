#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/flight_parts.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

// The preset is one more.
constexpr int kNumRequestFields = 9;

nlohmann::json FullRequest() {
  return nlohmann::json::parse(R"({
    "name": "meadow",
    "camera": {"width_px": 752, "height_px": 480, "fx_px": 465, "fy_px": 466, "cx_px": 375.5,
               "cy_px": 239.5, "distortion": {"model": "radtan", "coefficients": [0.1, -0.2, 0, 0]}},
    "body_from_camera": {"translation_m": [0.1, 0, 0.2], "quaternion_wxyz": [0.7071068, 0, 0, 0.7071068]},
    "origin": {"latitude_deg": 47.1, "longitude_deg": 8.2, "altitude_m": 500},
    "altitude_datum": "amsl",
    "aircraft": {"profile": "small", "glide_airspeed_mps": 12, "min_area_m2": 400},
    "options": {"stereo": {"ground_sampling_distance_m": 0.5},
                "backend": {"max_num_views": 50}}})");
}

std::string ErrorOfRequest(const nlohmann::json& request) {
  return ErrorOf([&request] { ParseFlightRequest(request.dump()); });
}

std::string ErrorWith(const char* pointer, const nlohmann::json& value) {
  nlohmann::json request = FullRequest();
  request[nlohmann::json::json_pointer(pointer)] = value;
  return ErrorOfRequest(request);
}

TEST_CASE("flight request: every part arrives") {
  const FlightRequest request = ParseFlightRequest(FullRequest().dump());
  CHECK(request.name == "meadow");
  REQUIRE(request.camera);
  CHECK(request.camera->fy_px == 466.0);
  CHECK(request.camera->source == CameraSource::kCalibrated);
  CHECK(request.camera->coefficients == std::vector<double>{0.1, -0.2, 0, 0});
  CHECK(request.body_from_camera->translation.z() == 0.2);
  CHECK(request.body_from_camera->rotation.norm() == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(request.origin->longitude_deg == 8.2);
  CHECK(request.altitude_datum == "amsl");
  CHECK(request.aircraft.landing_airspeed_mps == 10.0);
  CHECK(request.aircraft.glide_airspeed_mps == 12.0);
  CHECK(request.options.stereo.ground_sampling_distance_m == 0.5);
  CHECK(request.options.backend.max_num_views == 50);
}

TEST_CASE("flight request: a name is enough, and nulls are absent") {
  const FlightRequest request = ParseFlightRequest(R"({"name": "x", "camera": null})");
  CHECK_FALSE(request.camera);
  CHECK_FALSE(request.origin);
  CHECK(request.aircraft.profile == "techpod");
  // What the flight's input tells is not known here.
  CHECK_FALSE(request.altitude_datum);
  CHECK_FALSE(ParseStoredFlightRequest(request.canonical_json).altitude_datum);
}

TEST_CASE("flight request: a datum that is settled later stands in the stored request") {
  const FlightRequest request =
      WithAltitudeDatum(ParseFlightRequest(R"({"name": "x"})"), "ellipsoid");
  CHECK(request.altitude_datum == "ellipsoid");
  CHECK(ParseStoredFlightRequest(request.canonical_json).altitude_datum == "ellipsoid");
}

TEST_CASE("flight request: the least area of a region is the aircraft's unless another is stored") {
  const FlightRequest request = ParseFlightRequest(FullRequest().dump());
  CHECK(request.options.regions.min_area_m2 == 400.0);
  nlohmann::json stored = nlohmann::json::parse(request.canonical_json);
  stored["options"]["regions"]["min_area_m2"] = 123.0;
  CHECK(ParseStoredFlightRequest(stored.dump()).options.regions.min_area_m2 == 123.0);
}

TEST_CASE("flight request: the preset is stored and told again, with what was given beside it") {
  const FlightRequest request = ParseFlightRequest(
      R"({"name": "x", "options": {"preset": "paper", "terrain": {"cell_size_m": 2}}})");
  CHECK(request.options.preset == Preset::kPaper);
  // The paper has no ground roll.
  CHECK(request.aircraft.ground_roll_m == 0.0);
  const FlightRequest stored = ParseStoredFlightRequest(request.canonical_json);
  CHECK(stored.options.preset == Preset::kPaper);
  CHECK(stored.aircraft.ground_roll_m == 0.0);
  CHECK(stored.canonical_json == request.canonical_json);
  const nlohmann::json given = GivenOptionsJson(stored);
  CHECK(given == nlohmann::json::parse(R"({"preset": "paper", "terrain": {"cell_size_m": 2.0}})"));
}

TEST_CASE("flight request: a ground roll that is given beside the preset stays") {
  const FlightRequest request = ParseFlightRequest(
      R"({"name": "x", "aircraft": {"ground_roll_m": 20}, "options": {"preset": "paper"}})");
  CHECK(request.aircraft.ground_roll_m == 20.0);
}

TEST_CASE("flight request: without a preset only changed options are told") {
  CHECK(GivenOptionsJson(ParseFlightRequest(R"({"name": "x"})")).empty());
  const FlightRequest request = ParseFlightRequest(FullRequest().dump());
  CHECK(GivenOptionsJson(request) == FullRequest()["options"]);
}

TEST_CASE("flight request: the canonical form is a fixed point") {
  const FlightRequest request = ParseFlightRequest(FullRequest().dump());
  CHECK(ParseStoredFlightRequest(request.canonical_json).canonical_json == request.canonical_json);
}

TEST_CASE("flight request: what is wrong is refused where it is") {
  CHECK(ErrorOf([] { ParseFlightRequest(""); }) == "400 InvalidJson");
  CHECK(ErrorOf([] { ParseFlightRequest("[]"); }) == "422 InvalidValue ");
  CHECK(ErrorOf([] { ParseFlightRequest("{}"); }) == "422 InvalidValue /name");
  CHECK(ErrorWith("/name", "") == "422 InvalidValue /name");
  CHECK(ErrorWith("/name", 3) == "422 InvalidValue /name");
  CHECK(ErrorWith("/cammera", 1) == "422 UnknownKey /cammera");
  CHECK(ErrorWith("/camera/focal", 1) == "422 UnknownKey /camera/focal");
  CHECK(ErrorWith("/camera/a~1b~0", 1) == "422 UnknownKey /camera/a~1b~0");
  CHECK(ErrorWith("/camera/fx_px", 0) == "422 InvalidValue /camera/fx_px");
  CHECK(ErrorWith("/camera/fx_px", "465") == "422 InvalidValue /camera/fx_px");
  CHECK(ErrorWith("/camera/width_px", 752.5) == "422 InvalidValue /camera/width_px");
  CHECK(ErrorWith("/camera/width_px", -3) == "422 InvalidValue /camera/width_px");
  CHECK(ErrorWith("/camera/width_px", 18446744073709551615u) ==
        "422 InvalidValue /camera/width_px");
  CHECK(ErrorWith("/camera/distortion/model", "fov") ==
        "422 InvalidValue /camera/distortion/model");
  CHECK(ErrorWith("/camera/distortion/coefficients", nlohmann::json::array({1, 2, 3})) ==
        "422 InvalidValue /camera/distortion/coefficients");
  CHECK(ErrorWith("/camera/source", "exif") == "422 UnknownKey /camera/source");
  CHECK(ErrorWith("/body_from_camera/quaternion_wxyz", nlohmann::json::array({0, 0, 0, 0})) ==
        "422 InvalidValue /body_from_camera/quaternion_wxyz");
  CHECK(ErrorWith("/body_from_camera/translation_m/1", 1e4) ==
        "422 InvalidValue /body_from_camera/translation_m/1");
  CHECK(ErrorWith("/origin/latitude_deg", 95) == "422 InvalidValue /origin/latitude_deg");
  CHECK(ErrorWith("/origin/longitude_deg", nullptr) == "422 InvalidValue /origin/longitude_deg");
  CHECK(ErrorWith("/altitude_datum", "msl") == "422 InvalidValue /altitude_datum");
  CHECK(ErrorWith("/aircraft/profile", "zeppelin") == "422 InvalidValue /aircraft/profile");
  CHECK(ErrorWith("/aircraft/max_bank_deg", 95) == "422 InvalidValue /aircraft/max_bank_deg");
  CHECK(ErrorWith("/options/backend", {{"max_num_views", 1}}) ==
        "422 InvalidValue /options/backend/max_num_views");
  CHECK(ErrorWith("/options/preset", "ours") == "422 InvalidValue /options/preset");
  CHECK(ErrorWith("/aircraft/landing_surfaces", {"grass"}) == "nothing");
  CHECK(ErrorWith("/aircraft/landing_surfaces", {"grass", "soil"}) ==
        "422 SurfaceNotMeasured /aircraft/landing_surfaces/1");
  CHECK(ErrorWith("/aircraft/landing_surfaces", {"lake"}) ==
        "422 InvalidValue /aircraft/landing_surfaces/0");
  CHECK(ErrorWith("/aircraft/landing_surfaces", nlohmann::json::array()) ==
        "422 InvalidValue /aircraft/landing_surfaces");
  CHECK(ErrorWith("/aircraft/wingspan_m", 2) == "422 UnknownKey /aircraft/wingspan_m");
}

TEST_CASE("flight: a field of the engine that is no option of a request is refused by name") {
  CHECK(ErrorWith("/options/wind", {{"smoothing", 2}}) ==
        "422 RetiredOption /options/wind/smoothing");
  CHECK(ErrorWith("/options/terrain", {{"cell_size_m", 2}, {"outlier_sigma", nullptr}}) ==
        "nothing");
  CHECK(ErrorWith("/options/wind", {{"radius", 2}}) == "422 UnknownKey /options/wind/radius");
  CHECK(ErrorWith("/options", 3) == "422 InvalidValue /options");
  CHECK(ErrorWith("/options/wind", 3) == "422 InvalidValue /options/wind");
  CHECK(ErrorWith("/options/hazard", {{"cover_method", "rules"}}) ==
        "422 RetiredOption /options/hazard/cover_method");
  CHECK(ErrorWith("/options/hazard", {{"min_rut_contrast", 0}}) ==
        "422 RetiredOption /options/hazard/min_rut_contrast");
  CHECK(ErrorWith("/options/heights", 5) == "422 RetiredOption /options/heights");
  CHECK(ErrorWith("/options/heights", {{"method", "pairs"}}) ==
        "422 RetiredOption /options/heights");
  const nlohmann::json all = OptionsValuesJson(PipelineOptions{});
  int num_taken = 0;
  for (const auto& [stage, fields] : all.items()) {
    for (const auto& [name, value] : fields.items()) {
      const std::string pointer = "/options/" + stage + "/" + name;
      const std::string error = ErrorWith(pointer.c_str(), value);
      num_taken += error == "nothing";
      CHECK((error == "nothing" || error == "422 RetiredOption " + pointer));
    }
  }
  CHECK(num_taken == kNumRequestFields);
}

TEST_CASE(
    "flight: a stored request is read with all its options, without those of another version") {
  nlohmann::json request =
      nlohmann::json::parse(ParseFlightRequest(R"({"name": "x"})").canonical_json);
  request["options"]["approach"]["candidate_spacing_m"] = 7.0;
  CHECK(ParseStoredFlightRequest(request.dump()).options.approach.candidate_spacing_m == 7.0);
  request["options"]["approach"]["gone"] = 1.0;
  request["options"]["heights"] = {{"method", "pairs"}};
  CHECK(ParseStoredFlightRequest(request.dump()).options.approach.candidate_spacing_m == 7.0);
}

TEST_CASE("flight: the preset changes the aircraft only where the request does not") {
  const auto aircraft_of = [](const char* aircraft) {
    return ParseFlightRequest(R"({"name": "x", "options": {"preset": "paper"}, "aircraft": )" +
                              std::string(aircraft) + "}")
        .aircraft;
  };
  CHECK(aircraft_of("{}").ground_roll_m == 0.0);
  CHECK(aircraft_of("{}").max_failure_probability == 1.0);
  const Aircraft given = aircraft_of(R"({"max_failure_probability": 0.02})");
  CHECK(given.max_failure_probability == 0.02);
  CHECK(given.ground_roll_m == 0.0);
  CHECK(aircraft_of(R"({"ground_roll_m": 40})").ground_roll_m == 40.0);
}

}  // namespace
}  // namespace freelsd
