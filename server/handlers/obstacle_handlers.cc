// Obstacles that photographs do not show. Whoever changes them changes which stored sites are safe.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "api/import/obstacles/obstacles.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"
#include "server/recall/recall.h"

namespace freelsd {
namespace {

constexpr char kGeoJson[] = "application/geo+json";

bool IsExpired(const std::optional<int64_t>& expires_at_us) {
  return expires_at_us && *expires_at_us <= NowUs();
}

// `pointer` is the feature's place in the body.
ObstacleRow RowOf(const GivenObstacle& obstacle, const std::string& pointer) {
  if (IsExpired(obstacle.expires_at_us)) {
    throw ApiError("InvalidValue",
                   "expires_at: lies in the past",
                   {{pointer + "/properties/expires_at", "lies in the past"}});
  }
  return {obstacle.id,
          ObstacleFeature(obstacle).dump(),
          BoxOfPoints(obstacle.points),
          obstacle.expires_at_us};
}

nlohmann::json FeatureOf(const ObstacleRow& row) {
  nlohmann::json feature = nlohmann::json::parse(row.feature_json);
  feature["properties"]["updated_at"] = Rfc3339(row.updated_at_us);
  return feature;
}

std::optional<ObstacleRow> Find(const Service& service, const std::string& id) {
  std::optional<ObstacleRow> row = service.storage.obstacles.Find(id);
  if (row && IsExpired(row->expires_at_us)) return std::nullopt;
  return row;
}

void RefuseTooMany(const Service& service, const std::vector<ObstacleRow>& added) {
  std::set<std::string> ids;
  for (const ObstacleRow& row : service.storage.obstacles.List()) {
    if (!IsExpired(row.expires_at_us)) ids.insert(row.id);
  }
  for (const ObstacleRow& row : added) ids.insert(row.id);
  const size_t limit = kLimits.obstacles.max_num_stored;
  if (ids.size() <= limit) return;
  ApiError error("TooManyObstacles", "at most " + std::to_string(limit) + " obstacles are stored");
  error.limit = static_cast<double>(limit);
  error.observed = static_cast<double>(ids.size());
  throw error;
}

// Later than what is stored, or was removed, with the stamp of a clock that is ahead of this one.
int64_t StampFor(const Service& service, const std::string& id) {
  const auto last = service.storage.changes.Find({ChangeSubject::kObstacle, id});
  return last ? std::max(NowUs(), last->stamp_us + 1) : NowUs();
}

// Stamps them.
void Store(Service& service, std::vector<ObstacleRow>& rows) {
  {
    const std::lock_guard lock(service.obstacles_mutex);
    RefuseTooMany(service, rows);
    for (ObstacleRow& row : rows) row.updated_at_us = StampFor(service, row.id);
    service.storage.obstacles.Put(rows, NowUs());
  }
  service.alternates.WakeAll();
}

// A feature without an id has one from its content: the same import again changes nothing.
std::string IdOf(const GivenObstacle& obstacle) {
  constexpr size_t kNumDigits = 16;
  if (!obstacle.id.empty()) return obstacle.id;
  return "obstacle-" + Sha256Hex(ObstacleFeature(obstacle).dump()).substr(0, kNumDigits);
}

std::vector<ObstacleRow> RowsOf(ImportedObstacles imported) {
  std::vector<ObstacleRow> rows;
  std::set<std::string> ids;
  for (size_t i = 0; i < imported.obstacles.size(); ++i) {
    GivenObstacle& obstacle = imported.obstacles[i];
    const std::string pointer = "/features/" + std::to_string(i);
    obstacle.id = IdOf(obstacle);
    if (!ids.insert(obstacle.id).second) {
      throw ApiError("DuplicateId",
                     "id: " + obstacle.id + " is given twice",
                     {{pointer + "/id", "is given twice"}});
    }
    rows.push_back(RowOf(obstacle, pointer));
  }
  return rows;
}

// Lower case, without parameters. Empty if the request has none.
std::string MediaTypeOf(const Call& call) {
  const std::string type = LowerCase(call.request.get_header_value("Content-Type"));
  return type.substr(0, type.find_first_of("; \t"));
}

// False for OpenAir. The first bytes decide; where they are those of neither, the media type does.
bool IsJson(const std::string& body, const std::string& media_type) {
  static const std::set<std::string> kOfAnyText{
      "", "text/plain", "application/octet-stream", "application/x-www-form-urlencoded"};
  if (IsOpenAir(body)) return false;
  // A byte order mark may come first.
  const size_t first = body.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  const bool is_object = first != std::string::npos && body[first] == '{';
  if (is_object || media_type.ends_with("json")) return true;
  if (kOfAnyText.contains(media_type)) return false;
  throw ApiError("UnsupportedMediaType",
                 "obstacles must be a GeoJSON FeatureCollection or OpenAir text");
}

double WrappedDeg(double longitude_deg) { return std::remainder(longitude_deg, 360.0); }

bool Meets(const BoundingBox& a, const BoundingBox& box) {
  if (a.south_deg > box.north_deg || a.north_deg < box.south_deg) return false;
  if (box.west_deg <= box.east_deg) {
    return a.west_deg <= box.east_deg && a.east_deg >= box.west_deg;
  }
  return a.east_deg >= WrappedDeg(box.west_deg) || a.west_deg <= WrappedDeg(box.east_deg);
}

}  // namespace

void PutObstacle(Service& service, const Call& call, httplib::Response& response) {
  const std::string& id = call.Id("obstacle");
  if (!IsValidId(id)) {
    throw ApiError("InvalidId", "the id must match [A-Za-z0-9._-]{1,128}");
  }
  const size_t max_bytes = kLimits.obstacles.max_bytes;
  GivenObstacle obstacle = ParseObstacle(ParseJson(call.body.ReadAll(max_bytes), max_bytes), "");
  if (!obstacle.id.empty() && obstacle.id != id) {
    throw ApiError("InvalidValue", "id: differs from the id in the URL", {{"/id", "differs"}});
  }
  obstacle.id = id;
  const bool is_new = !Find(service, id);
  std::vector<ObstacleRow> rows{RowOf(obstacle, "")};
  Store(service, rows);
  response.status = is_new ? 201 : 200;
  response.set_content(FeatureOf(rows[0]).dump(), kGeoJson);
}

void PostObstacles(Service& service, const Call& call, httplib::Response& response) {
  const std::string body = call.body.ReadAll(kLimits.obstacles.max_import_bytes);
  ImportedObstacles imported =
      IsJson(body, MediaTypeOf(call)) ? ParseObstacles(body) : ParseOpenAir(body);
  const std::vector<std::string> warnings = imported.warnings;
  std::vector<ObstacleRow> rows = RowsOf(std::move(imported));
  Store(service, rows);
  nlohmann::json ids = nlohmann::json::array();
  for (const ObstacleRow& row : rows) ids.push_back(row.id);
  response.set_content(nlohmann::json{{"ids", ids}, {"warnings", warnings}}.dump(),
                       "application/json");
}

void GetObstacles(Service& service, const Call& call, httplib::Response& response) {
  const std::optional<BoundingBox> box = ParseBoundingBox(call);
  std::string features;
  for (const ObstacleRow& row : service.storage.obstacles.List()) {
    if (IsExpired(row.expires_at_us) || (box && !Meets(row.box, *box))) continue;
    features += (features.empty() ? "" : ",") + FeatureOf(row).dump();
  }
  response.set_content(R"({"type":"FeatureCollection","features":[)" + features + "]}", kGeoJson);
}

void GetObstacle(Service& service, const Call& call, httplib::Response& response) {
  const std::optional<ObstacleRow> row = Find(service, call.Id("obstacle"));
  if (!row) throw ApiError("NoSuchObstacle", "there is no such obstacle");
  response.set_content(FeatureOf(*row).dump(), kGeoJson);
}

void DeleteObstacle(Service& service, const Call& call, httplib::Response& response) {
  const std::string& id = call.Id("obstacle");
  const bool is_there = Find(service, id).has_value();
  if (!service.storage.obstacles.Delete(id) || !is_there) {
    throw ApiError("NoSuchObstacle", "there is no such obstacle");
  }
  service.alternates.WakeAll();
  response.status = 204;
}

}  // namespace freelsd
