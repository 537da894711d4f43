// What comes as text: bodies, pose files, telemetry, queries, heads, multipart.
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "api/import/links/links.h"
#include "api/import/obstacles/obstacles.h"
#include "api/import/poses/poses.h"
#include "api/stored/stored.h"
#include "server/http/call.h"
#include "server/http/connections/request_reader.h"
#include "server/http/multipart.h"
#include "server/http/request_head.h"
#include "server/intake/telemetry.h"
#include "tests/fuzz/targets.h"

namespace freelsd {
namespace {

// Ends the process where a promise is not kept.
void Demand(bool is_kept) {
  if (!is_kept) std::abort();
}

void DemandFinite(const FrameMeta& meta) {
  if (meta.position) {
    Demand(std::isfinite(meta.position->latitude_deg) &&
           std::isfinite(meta.position->longitude_deg) && std::isfinite(meta.position->altitude_m));
  }
  if (meta.ned_from_body) Demand(meta.ned_from_body->coeffs().allFinite());
  if (meta.ned_from_camera) Demand(meta.ned_from_camera->coeffs().allFinite());
  if (meta.wind_in_world) Demand(meta.wind_in_world->allFinite());
  if (meta.height_above_ground_m) Demand(std::isfinite(*meta.height_above_ground_m));
}

void DemandPoses(const PoseFile& file) {
  for (const auto& [id, meta] : file.poses) {
    Demand(IsValidId(id));
    DemandFinite(meta);
  }
  if (file.camera) file.camera->Check();
}

}  // namespace

// The first byte says which body.
void FuzzJsonBodies(std::string_view bytes) {
  if (bytes.empty()) return;
  const std::string text(bytes.substr(1));
  if (bytes[0] == 'm') {
    const FrameMeta meta = ParseFrameMeta(text);
    DemandFinite(meta);
    Demand(FrameMetaJson(ParseStoredFrameMeta(FrameMetaJson(meta))) == FrameMetaJson(meta));
  } else if (bytes[0] == 'a') {
    ParseAircraft(ParseJson(text), "/aircraft").Check();
  } else {
    const FlightRequest request = ParseFlightRequest(text);
    Demand(ParseStoredFlightRequest(request.canonical_json).canonical_json ==
           request.canonical_json);
  }
}

void FuzzPoses(std::string_view bytes) { DemandPoses(ParsePoses(bytes)); }

// Files by "=== name" lines.
void FuzzSideFiles(std::string_view bytes) {
  std::vector<SideFile> files;
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("=== ")) {
      files.push_back({line.substr(4), ""});
    } else if (!files.empty()) {
      files.back().text += line + "\n";
    }
  }
  SideContext context;
  FrameMeta tagged;
  tagged.position = GeoPoint{47.0, 8.0, 500.0};
  for (int i = 0; i < 4; ++i) {
    tagged.position->latitude_deg += 1e-4 * (i % 2);
    tagged.position->longitude_deg += 1e-4;
    context.image_tags.emplace_back(std::to_string(i) + ".jpg", tagged);
  }
  DemandPoses(PosesFromFiles(files, context));
}

void FuzzTelemetry(std::string_view bytes) {
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    try {
      for (const TelemetryRow& row : ParseTelemetryLine(line)) {
        for (const double value : row.values) Demand(std::isfinite(value));
      }
    } catch (const ApiError&) {
      continue;
    }
  }
}

// What a link reports, and a command for it.
void FuzzLinks(std::string_view bytes) {
  const std::string text(bytes);
  try {
    Demand(IsValidId(ParseMissionRequest(text).site_id));
  } catch (const ApiError&) {
    const LinkReport report = ParseLinkReport(text);
    Demand(!report.run.empty() && report.state.is_object());
    // It is told again as it is kept.
    Demand(ParseLinkReport(report.state.dump()).run == report.run);
  }
}

namespace {

void DemandObstacle(const GivenObstacle& obstacle) {
  Demand(!obstacle.points.empty());
  for (const GeoPoint& point : obstacle.points) {
    Demand(std::abs(point.latitude_deg) <= 90.0 && std::abs(point.longitude_deg) <= 180.0);
    Demand(!std::isinf(point.altitude_m));
  }
  Demand(std::isfinite(obstacle.position_sd_m));
  const nlohmann::json feature = ObstacleFeature(obstacle);
  Demand(ObstacleFeature(ParseStoredObstacle(feature)) == feature);
}

}  // namespace

// A feature or a collection.
void FuzzObstacles(std::string_view bytes) {
  const std::string text(bytes);
  if (text.find("\"FeatureCollection\"") == std::string::npos) {
    DemandObstacle(ParseObstacle(ParseJson(text), ""));
    return;
  }
  for (const GivenObstacle& obstacle : ParseObstacles(text).obstacles) DemandObstacle(obstacle);
}

void FuzzOpenAir(std::string_view bytes) {
  IsOpenAir(bytes);
  for (const GivenObstacle& obstacle : ParseOpenAir(bytes).obstacles) {
    Demand(IsValidId(obstacle.id));
    DemandObstacle(obstacle);
  }
}

void FuzzQuery(std::string_view bytes) {
  httplib::Params parameters;
  httplib::detail::parse_query_text(std::string(bytes), parameters);
  for (const auto& [name, value] : parameters) {
    try {
      Demand(std::isfinite(ParseQueryNumber(value, name)));
    } catch (const ApiError& error) {
      // The parameter's name goes into the answer, whatever its bytes.
      Demand(nlohmann::json::parse(ProblemJson(error)).is_object());
    }
  }
}

namespace {

// What a reader makes of bytes that arrive `step` at a time; nothing: a refusal.
std::optional<RequestReader::State> StateAfter(std::string_view bytes, size_t step) {
  using State = RequestReader::State;
  RequestRules rules;
  rules.allowed_hosts = {"freelsd.test"};
  rules.takes_large_bodies = false;
  RequestReader reader(rules);
  std::string buffered;
  State state = State::kNothing;
  try {
    for (size_t i = 0; i < bytes.size() && state != State::kWhole; i += step) {
      buffered += bytes.substr(i, step);
      state = reader.Advance(buffered);
    }
  } catch (const ApiError&) {
    return std::nullopt;
  }
  return state;
}

}  // namespace

void FuzzRequestHead(std::string_view bytes) {
  Demand(StateAfter(bytes, 1) == StateAfter(bytes, bytes.size() + 1));
  const RequestHead head = ParseRequestHead(std::string(bytes) + "\r\n\r\n", {}, {"freelsd.test"});
  Demand(head.forwarded.ends_with("\r\n\r\n"));
  Demand(head.forwarded.find("\r\n\r\n") == head.forwarded.size() - 4);
  Demand(head.forwarded.find('\0') == std::string::npos);
}

// The boundary is "x"; parts are read up to a small size, so that some are skipped.
void FuzzMultipart(std::string_view bytes) {
  size_t position = 0;
  MultipartReader parts(
      [bytes, &position](char* to, size_t size) {
        // In small pieces: delimiters fall between them.
        const size_t num_read = bytes.substr(position).copy(to, std::min<size_t>(size, 7));
        position += num_read;
        return num_read;
      },
      "x");
  while (const std::optional<Part> part = parts.Next()) {
    const auto content = parts.ReadAll(256);
    if (content) Demand(content->size() <= 256);
    IdFromFileName(part->file_name);
  }
  MultipartBoundary(std::string(bytes));
}

}  // namespace freelsd
