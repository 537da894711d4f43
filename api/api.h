// The wire: JSON <-> engine types, and the errors of the HTTP contract. Knows no sockets, no SQL.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/pipeline.h"

namespace freelsd {

// --- Errors (RFC 9457) ---------------------------------------------------------------------------

struct FieldError {
  std::string pointer;  // RFC 6901 into the body, or a query parameter's name
  std::string detail;
};

// Thrown for anything a client did wrong, or that the server cannot do now; server/ turns it into
// problem+json. `code` is stable CamelCase; one table (error.cc) gives its HTTP status and title; a
// code that is not in it is 500.
class ApiError : public std::runtime_error {
 public:
  ApiError(std::string code, const std::string& detail, std::vector<FieldError> errors = {});
  const std::string& code() const { return code_; }
  int http_status() const;
  const std::vector<FieldError>& errors() const { return errors_; }
  // Where a limit was passed.
  std::optional<double> limit;
  std::optional<double> observed;

 private:
  std::string code_;
  std::vector<FieldError> errors_;
};

// Body of application/problem+json for an error, or for a bare status made before routing.
std::string ProblemJson(const ApiError& error);
std::string ProblemJson(int http_status, const std::string& code, const std::string& detail);
// Seconds after which a retry makes sense (429, 503), else nothing.
std::optional<int> RetryAfterSeconds(const std::string& code);

// --- Requests ------------------------------------------------------------------------------------

// Strict JSON: depth at most 32, no duplicate keys, no NaN, no 1e999. Throws ApiError 400/413.
nlohmann::json ParseJson(const std::string& text, size_t max_bytes = 1 << 20);

// POST /v1/flights, also as stored: `canonical_json` parses to the same request again.
struct FlightRequest {
  std::string name;
  std::optional<Camera> camera;
  std::optional<Rigid3d> body_from_camera;
  std::optional<GeoPoint> origin;
  std::string altitude_datum = "unknown";
  Aircraft aircraft;
  PipelineOptions options;
  std::string canonical_json;
};
FlightRequest ParseFlightRequest(const std::string& body);
// PipelineOptions::Check, with its sentence turned into an ApiError at /options/<stage>/<field>.
void CheckOptions(const PipelineOptions& options);
// Object of aircraft fields over a profile; pointers in errors start with `pointer`.
Aircraft ParseAircraft(const nlohmann::json& object, const std::string& pointer);

// {width_px, …} as in the contract, and "source": "exif" where it is not calibrated.
nlohmann::json CameraJson(const Camera& camera);
nlohmann::json GeoPointJson(const GeoPoint& point);
// What a flight's frames are placed with once it is resolved, as stored; exact both ways.
struct FlightRig {
  Rig rig;
  GeoPoint origin;
};
std::string FlightRigJson(const FlightRig& flight_rig);
FlightRig ParseStoredFlightRig(const std::string& text);

// What is known of a frame besides its image: from meta, CSV, NDJSON, or the image's tags.
struct FrameMeta {
  std::optional<int64_t> timestamp_us;
  std::optional<GeoPoint> position;
  // ned_from_body.
  std::optional<Eigen::Quaterniond> ned_from_body;
  // Of the camera itself, where a gimbal says it; wins over ned_from_body.
  std::optional<Eigen::Quaterniond> ned_from_camera;
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> height_above_ground_m;
  std::optional<double> position_sd_m;
  std::optional<double> attitude_sd_deg;
};
FrameMeta ParseFrameMeta(const std::string& json_text);
// As stored: equal metas give equal bytes, and ParseStoredFrameMeta reads them back exactly.
std::string FrameMetaJson(const FrameMeta& meta);
FrameMeta ParseStoredFrameMeta(const std::string& text);
// Fields of `first` where set, else of `second` (meta over CSV over telemetry over geotags). A
// deviation belongs to its position or attitude: the one of `second` never describes `first`'s.
FrameMeta Merged(const FrameMeta& first, const FrameMeta& second);
// Engine frame from an image and what is known of it. Throws ApiError NoPosition without position,
// ImageSizeMismatch when the image is not of the camera's size.
Frame MakeFrame(const std::string& frame_id,
                const cv::Mat& image,
                const FrameMeta& meta,
                const Rig& rig,
                const LocalFrame& local_frame,
                int64_t fallback_timestamp_us);

// --- Responses -----------------------------------------------------------------------------------
// Regions and sites are stored as JSON text of their GeoJSON feature; rank is set when answering.

// What of a flight the engine types do not carry.
struct FlightContext {
  std::string flight_id;
  std::string altitude_datum;
  LocalFrame local_frame;
};
nlohmann::json RegionFeature(const Region& region,
                             const std::optional<WindEstimate>& wind,
                             const FlightContext& context);
nlohmann::json RegionHistoryJson(const Region& region);
// site_id: stable, e.g. "<flight>-<region>". map_position_sd etc. as in the contract.
nlohmann::json SiteFeature(const std::string& site_id,
                           const Site& site,
                           const Aircraft& aircraft,
                           const std::string& updated_at,
                           const FlightContext& context);
// FeatureCollection with kind = approach, loiter, touchdown, and `profile`. Throws ApiError
// NoApproach (409) where the plan has none.
nlohmann::json ApproachJson(const Plan& plan, const FlightContext& context);
// {directions_deg, speeds_mps, altitude_datum, entries}: speed by speed, in it direction by
// direction; directions are where the wind comes from.
nlohmann::json WindRoseJson(const WindRose& rose, const FlightContext& context);
// What a person who takes a site by these limits has to be told; nothing for a known profile's.
std::vector<std::string> LimitsWarnings(const Aircraft& aircraft);
// The part of a site's properties that a plan decides (verdict, score, approach, rejections, ...).
nlohmann::json PlanProperties(const Plan& plan, const FlightContext& context);
// FeatureCollection in ranking order (landable, unverified, rejected; then score), rank from 1.
nlohmann::json RankedSites(std::vector<nlohmann::json> features);
nlohmann::json AircraftJson(const Aircraft& aircraft);
// {options: {stage: {field: {default, unit, help}}}, aircraft_profiles: {name: {…}}}.
nlohmann::json OptionsJson();
// The contract: api/openapi.yaml, which is JSON (valid JSON is valid YAML).
std::string_view OpenApiJson();

}  // namespace freelsd
