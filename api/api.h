// Conversion between JSON and engine types, and the errors of the HTTP API. Independent of sockets
// and SQL.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "api/capture_time.h"
#include "api/limits.h"
#include "engine/pipeline.h"

namespace freelsd {

// --- Errors (RFC 9457) ---------------------------------------------------------------------------

struct FieldError {
  std::string pointer;  // RFC 6901 into the body, or a query parameter's name
  std::string detail;
};

// Thrown if a request is invalid or cannot be served now. server/ answers it with problem+json.
// `code` is a stable CamelCase name. A table in error.cc gives its HTTP status and title; a code
// outside the table has status 500.
class ApiError : public std::runtime_error {
 public:
  ApiError(std::string code, const std::string& detail, std::vector<FieldError> errors = {});
  const std::string& code() const { return code_; }
  int http_status() const;
  const std::vector<FieldError>& errors() const { return errors_; }
  // `limit` and `observed` are set if a limit is exceeded.
  std::optional<double> limit;
  std::optional<double> observed;

 private:
  std::string code_;
  std::vector<FieldError> errors_;
};

// Body of application/problem+json for an error, or for a status that is set before routing.
std::string ProblemJson(const ApiError& error);
std::string ProblemJson(int http_status, const std::string& code, const std::string& detail);
// Seconds after which a retry may succeed; nothing if a retry cannot succeed.
std::optional<int> RetryAfterSeconds(const std::string& code);

// --- Requests ------------------------------------------------------------------------------------

// Strict JSON: limited depth, no duplicate keys, no NaN, no 1e999. Throws ApiError 400 or 413.
nlohmann::json ParseJson(const std::string& text, size_t max_bytes = kLimits.json.max_bytes);

// Whether a flight's sites enter the memory of all flights, and its maps judge their sites.
struct FlightMemory {
  // False: an experiment ("none").
  bool is_kept = true;
  // Why, as a part of a sentence.
  std::string reason = "it is the default";
};
// "keep" or "none".
const char* NameOf(const FlightMemory& memory);

// Body of POST /v1/flights. It is stored as `canonical_json`, which parses to the same request.
struct FlightRequest {
  std::string name;
  std::optional<Camera> camera;
  std::optional<Rigid3d> body_from_camera;
  std::optional<GeoPoint> origin;
  // "amsl", "ellipsoid" or "unknown". Empty: the datum is taken from the flight's frames.
  std::optional<std::string> altitude_datum;
  Aircraft aircraft;
  PipelineOptions options;
  FlightMemory memory;
  std::string canonical_json;
};
FlightRequest ParseFlightRequest(const std::string& body);
// Of a stored `canonical_json`, with all of its options. One that this version does not have is an
// error: whoever removes an option raises the numbers of the schemas.
FlightRequest ParseStoredFlightRequest(const std::string& canonical_json);
// The same request with this datum, as if the client had given it.
FlightRequest WithAltitudeDatum(FlightRequest request, const std::string& altitude_datum);
// What the request's options change: the preset, and the fields that differ from the preset or from
// the defaults.
nlohmann::json GivenOptionsJson(const FlightRequest& request);
// Calls PipelineOptions::Check; its message becomes an ApiError at /options/<stage>/<field>.
void CheckOptions(const PipelineOptions& options);
// `object` may name a profile. Its other fields override those of the profile. Pointers in errors
// start with `pointer`.
Aircraft ParseAircraft(const nlohmann::json& object, const std::string& pointer);

// {width_px, …} as in openapi.yaml. "source" is "exif" if the camera was derived from image tags.
nlohmann::json CameraJson(const Camera& camera);
nlohmann::json GeoPointJson(const GeoPoint& point);

// Pose, time and wind of a frame. Sources are the meta sent with the image, a pose file, telemetry,
// and the image's tags.
struct FrameMeta {
  std::optional<int64_t> timestamp_us;
  TimeSource time_source = TimeSource::kGiven;
  std::optional<GeoPoint> position;
  // Datum of the position's altitude, "amsl" or "ellipsoid". Empty if the source does not state it.
  std::optional<std::string> altitude_datum;
  // NED is north-east-down; the body is forward-right-down.
  std::optional<Eigen::Quaterniond> ned_from_body;
  // Attitude of the camera itself, from a gimbal. Overrides ned_from_body.
  std::optional<Eigen::Quaterniond> ned_from_camera;
  std::optional<Eigen::Vector2d> wind_in_world;
  std::optional<double> height_above_ground_m;
  std::optional<double> position_sd_m;
  std::optional<double> attitude_sd_deg;
};
FrameMeta ParseFrameMeta(const std::string& json_text);
// Each field is taken from `first` if set there, else from `second`. Exception: a standard
// deviation or datum is taken from the same source as its position or attitude, never from the
// other source.
FrameMeta Merged(const FrameMeta& first, const FrameMeta& second);
// Engine frame from an image and its meta. Throws ApiError NoPosition if `meta` has no position,
// ImageSizeMismatch if the image and the camera differ in size.
Frame MakeFrame(const std::string& frame_id,
                const cv::Mat& image,
                const FrameMeta& meta,
                const Rig& rig,
                const LocalFrame& local_frame,
                int64_t fallback_timestamp_us);

// --- Responses -----------------------------------------------------------------------------------
// Regions and sites are stored as GeoJSON features without rank. Each answer adds the rank.

// The flight's data that the engine's types do not contain.
struct FlightContext {
  std::string flight_id;
  std::string altitude_datum;
  LocalFrame local_frame;
};
nlohmann::json RegionFeature(const Region& region,
                             const std::optional<WindEstimate>& wind,
                             const FlightContext& context);
nlohmann::json RegionHistoryJson(const Region& region);
// `site_id` is stable, for example "<flight>-<region>". `updated_at` is ISO 8601 in UTC.
nlohmann::json SiteFeature(const std::string& site_id,
                           const Site& site,
                           const Aircraft& aircraft,
                           const std::string& updated_at,
                           const FlightContext& context);
// FeatureCollection of kinds approach, loiter, touchdown, ground_roll and go_around, with
// `profile`. Throws
// ApiError NoApproach (409) if the plan has no approach.
nlohmann::json ApproachJson(const Plan& plan, const FlightContext& context);
// {directions_deg, speeds_mps, altitude_datum, entries}. Entries are ordered by speed, then by
// direction. A direction is where the wind comes from.
nlohmann::json WindRoseJson(const WindRose& rose, const FlightContext& context);
// {verdict, rules, first_failed, evidence}: why the planner does or does not touch down at a place.
// Frames and cues of the evidence are null: the map knows them.
nlohmann::json PlaceJudgementJson(const PlaceJudgement& judgement,
                                  const Eigen::Vector2d& place_in_world,
                                  const FlightContext& context);
// A duration for people, rounded down: "365 days", "5 hours" or "12 minutes".
std::string AgeText(double age_s);
// Warnings for pilots if the aircraft's limits are looser than those of every known profile.
std::vector<std::string> LimitsWarnings(const Aircraft& aircraft);
// The site properties that depend on the plan (verdict, score, approach, rejections, ...).
nlohmann::json PlanProperties(const Plan& plan, const FlightContext& context);
// Name as in openapi.yaml, for example "approach_blocked".
std::string NameOf(RejectReason reason);
// The smaller key ranks first. Verdicts are ordered landable, unverified, unverified and doubted by
// a later map, any other; equal verdicts are ordered by descending score, then by id.
using RankKey = std::tuple<int, double, std::string>;
inline constexpr int kDoubtedRank = 2;
RankKey RankKeyOf(const nlohmann::json& site_feature);
// FeatureCollection ordered by verdict (landable, unverified, rejected), then score; rank from 1.
nlohmann::json RankedSites(std::vector<nlohmann::json> features);
nlohmann::json AircraftJson(const Aircraft& aircraft);
// {options: {preset: {default, unit, help, changes_verdicts}, stage: {field: {…}}},
// aircraft_profiles: {name: {…}}}. The options are those that a request may set.
nlohmann::json OptionsJson();
// The object `limits` of GET /v1/info: one number per limit. The server adds its own limits.
nlohmann::json LimitsJson(const Limits& limits);
// Text of api/openapi.yaml, which is written as JSON (valid JSON is valid YAML).
std::string_view OpenApiJson();

}  // namespace freelsd
