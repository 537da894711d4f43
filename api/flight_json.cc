#include <algorithm>
#include <stdexcept>
#include <utility>

#include "api/flight_parts.h"
#include "api/json_reader.h"

namespace freelsd {
namespace {

// A camera is inside the aircraft. A larger distance from the body's origin means wrong units.
constexpr double kMaxLeverArm = 100.0;
constexpr const char* kKeep = "keep";
constexpr const char* kNone = "none";
constexpr NumberRange kImageSideRange{1, 65535};
constexpr std::pair<DistortionModel, const char*> kDistortionNames[] = {
    {DistortionModel::kNone, "none"},
    {DistortionModel::kRadTan, "radtan"},
    {DistortionModel::kEquidistant, "equidistant"}};

int ReadSide(ObjectReader& reader, const std::string& key) {
  const nlohmann::json& value = reader.Required(key);
  const int64_t side = ReadInteger(value, reader.PointerTo(key));
  ReadNumber(value, reader.PointerTo(key), kImageSideRange);
  return static_cast<int>(side);
}

Camera WithDistortion(Camera camera, ObjectReader& reader) {
  const nlohmann::json* const value = reader.Find("distortion");
  if (value == nullptr) return camera;
  ObjectReader distortion(*value, reader.PointerTo("distortion"));
  const std::string pointer = distortion.PointerTo("model");
  const std::string model = ReadString(distortion.Required("model"), pointer);
  const auto* const named = std::find_if(
      std::begin(kDistortionNames), std::end(kDistortionNames), [&model](const auto& each) {
        return each.second == model;
      });
  if (named == std::end(kDistortionNames)) {
    throw InvalidValue(pointer, "model: must be one of none, radtan, equidistant");
  }
  camera.distortion = named->first;
  if (const nlohmann::json* const coefficients = distortion.Find("coefficients")) {
    camera.coefficients =
        ReadNumbers(*coefficients, distortion.PointerTo("coefficients"), std::nullopt);
  }
  distortion.RefuseUnknownKeys();
  return camera;
}

std::string ReadName(ObjectReader& reader) {
  std::string name = ReadString(reader.Required("name"), "/name");
  if (name.empty() || name.size() > kLimits.max_name_bytes || HasControlCharacter(name)) {
    throw InvalidValue("/name",
                       "name: must have 1 to " + std::to_string(kLimits.max_name_bytes) +
                           " bytes and no control characters");
  }
  return name;
}

std::optional<std::string> ReadDatum(ObjectReader& reader) {
  const nlohmann::json* const value = reader.Find("altitude_datum");
  if (value == nullptr) return std::nullopt;
  std::string datum = ReadString(*value, "/altitude_datum");
  if (datum != "amsl" && datum != "ellipsoid" && datum != "unknown") {
    throw InvalidValue("/altitude_datum",
                       "altitude_datum: must be one of amsl, ellipsoid, unknown");
  }
  return datum;
}

// With the preset, the aircraft has the paper's rules unless the request gives others.
Aircraft ReadAircraft(const nlohmann::json* value, Preset preset) {
  const nlohmann::json given = value == nullptr ? nlohmann::json::object() : *value;
  Aircraft aircraft = ParseAircraft(given, "/aircraft");
  if (preset != Preset::kPaper) return aircraft;
  const auto is_given = [&given](const char* field) {
    return given.contains(field) && !given.at(field).is_null();
  };
  Aircraft paper = PaperAircraft(aircraft);
  if (is_given("ground_roll_m")) paper.ground_roll_m = aircraft.ground_roll_m;
  if (is_given("max_failure_probability")) {
    paper.max_failure_probability = aircraft.max_failure_probability;
  }
  return paper;
}

// The aircraft gives the least area of a region unless the request sets it.
PipelineOptions WithLeastArea(PipelineOptions options,
                              const nlohmann::json* value,
                              const Aircraft& aircraft) {
  const nlohmann::json::json_pointer area("/regions/min_area_m2");
  if (value == nullptr || !value->contains(area) || value->at(area).is_null()) {
    options.regions.min_area_m2 = aircraft.min_area_m2;
  }
  return options;
}

FlightMemory ReadMemory(const nlohmann::json* value, const FlightRequest& request) {
  if (value == nullptr) return DefaultMemory(request);
  const std::string memory = ReadString(*value, "/memory");
  if (memory != kKeep && memory != kNone) {
    throw InvalidValue("/memory", "memory: must be keep or none");
  }
  return {memory == kKeep, "the request says so"};
}

std::string CanonicalJson(const FlightRequest& request) {
  nlohmann::json object{{"name", request.name},
                        {"memory", NameOf(request.memory)},
                        {"memory_reason", request.memory.reason},
                        {"aircraft", AircraftJson(request.aircraft)},
                        {"options", OptionsValuesJson(request.options)}};
  if (request.altitude_datum) object["altitude_datum"] = *request.altitude_datum;
  if (request.camera) object["camera"] = CameraJson(*request.camera);
  if (request.body_from_camera) object["body_from_camera"] = Rigid3Json(*request.body_from_camera);
  if (request.origin) object["origin"] = GeoPointJson(*request.origin);
  return object.dump();
}

// With any option: requests that are stored may have more than new ones.
FlightRequest ReadFlightRequest(const nlohmann::json& object) {
  ObjectReader reader(object, "");
  reader.RefuseKeysExcept({"name",
                           "camera",
                           "body_from_camera",
                           "origin",
                           "altitude_datum",
                           "aircraft",
                           "options",
                           "memory"});
  FlightRequest request;
  request.name = ReadName(reader);
  if (const nlohmann::json* const camera = reader.Find("camera")) {
    request.camera = ParseCamera(*camera, "/camera", CameraOrigin::kClient);
  }
  if (const nlohmann::json* const body_from_camera = reader.Find("body_from_camera")) {
    request.body_from_camera = ParseRigid3(*body_from_camera, "/body_from_camera");
  }
  if (const nlohmann::json* const origin = reader.Find("origin")) {
    request.origin = ReadGeoPoint(*origin, "/origin");
  }
  request.altitude_datum = ReadDatum(reader);
  const nlohmann::json* const aircraft = reader.Find("aircraft");
  const nlohmann::json* const options = reader.Find("options");
  const nlohmann::json* const memory = reader.Find("memory");
  reader.RefuseUnknownKeys();
  if (options != nullptr) request.options = ParseOptions(*options, "/options");
  request.aircraft = ReadAircraft(aircraft, request.options.preset);
  request.options = WithLeastArea(std::move(request.options), options, request.aircraft);
  CheckOptions(request.options);
  request.memory = ReadMemory(memory, request);
  request.canonical_json = CanonicalJson(request);
  return request;
}

}  // namespace

const char* NameOf(const FlightMemory& memory) { return memory.is_kept ? kKeep : kNone; }

Camera ParseCamera(const nlohmann::json& object, const std::string& pointer, CameraOrigin origin) {
  ObjectReader reader(object, pointer);
  std::set<std::string> known{
      "width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "readout_s", "distortion"};
  if (origin == CameraOrigin::kStored) known.insert("source");
  reader.RefuseKeysExcept(known);
  Camera camera;
  camera.width_px = ReadSide(reader, "width_px");
  camera.height_px = ReadSide(reader, "height_px");
  camera.fx_px = reader.RequiredNumber("fx_px");
  camera.fy_px = reader.RequiredNumber("fy_px");
  camera.cx_px = reader.RequiredNumber("cx_px");
  camera.cy_px = reader.RequiredNumber("cy_px");
  camera.readout_s = reader.Number("readout_s").value_or(0.0);
  camera = WithDistortion(camera, reader);
  if (origin == CameraOrigin::kStored && reader.Find("source") != nullptr) {
    camera.source = CameraSource::kExif;
  }
  reader.RefuseUnknownKeys();
  try {
    camera.Check();
  } catch (const std::invalid_argument& error) {
    throw FromCheck(error, pointer, "camera.");
  }
  return camera;
}

nlohmann::json CameraJson(const Camera& camera) {
  nlohmann::json object{{"width_px", camera.width_px},
                        {"height_px", camera.height_px},
                        {"fx_px", camera.fx_px},
                        {"fy_px", camera.fy_px},
                        {"cx_px", camera.cx_px},
                        {"cy_px", camera.cy_px}};
  for (const auto& [model, name] : kDistortionNames) {
    if (model == camera.distortion) {
      object["distortion"] = {{"model", name}, {"coefficients", camera.coefficients}};
    }
  }
  if (camera.readout_s > 0.0) object["readout_s"] = camera.readout_s;
  if (camera.source == CameraSource::kExif) object["source"] = "exif";
  return object;
}

Rigid3d ParseRigid3(const nlohmann::json& object, const std::string& pointer) {
  ObjectReader reader(object, pointer);
  reader.RefuseKeysExcept({"translation_m", "quaternion_wxyz"});
  Rigid3d a_from_b;
  const std::string at = reader.PointerTo("translation_m");
  const nlohmann::json& translation = reader.Required("translation_m");
  const std::vector<double> xyz = ReadNumbers(translation, at, 3);
  for (int i = 0; i < 3; ++i) {
    a_from_b.translation[i] =
        ReadNumber(translation[i], at + "/" + std::to_string(i), {-kMaxLeverArm, kMaxLeverArm});
  }
  a_from_b.rotation =
      ReadQuaternion(reader.Required("quaternion_wxyz"), reader.PointerTo("quaternion_wxyz"));
  reader.RefuseUnknownKeys();
  return a_from_b;
}

nlohmann::json Rigid3Json(const Rigid3d& a_from_b) {
  const Eigen::Vector3d& t = a_from_b.translation;
  return {{"translation_m", {t.x(), t.y(), t.z()}},
          {"quaternion_wxyz", QuaternionJson(a_from_b.rotation)}};
}

FlightRequest ParseFlightRequest(const std::string& body) {
  const nlohmann::json object = ParseJson(body);
  if (object.is_object() && object.contains("options")) {
    RefuseRetiredOptions(object.at("options"), "/options");
  }
  return ReadFlightRequest(object);
}

FlightRequest ParseStoredFlightRequest(const std::string& canonical_json) {
  nlohmann::json object = ParseJson(canonical_json);
  const std::string reason = object.at("memory_reason");
  object.erase("memory_reason");
  if (object.contains("options")) object["options"] = WithoutUnknownOptions(object.at("options"));
  FlightRequest request = ReadFlightRequest(object);
  request.memory.reason = reason;
  request.canonical_json = CanonicalJson(request);
  return request;
}

FlightRequest WithAltitudeDatum(FlightRequest request, const std::string& altitude_datum) {
  request.altitude_datum = altitude_datum;
  request.canonical_json = CanonicalJson(request);
  return request;
}

}  // namespace freelsd
