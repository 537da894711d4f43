// The feed of changes, for servers that follow this one, and what they send back.
#include <chrono>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "server/following/following.h"
#include "server/handlers/bounding_box.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {
namespace {

constexpr int64_t kMaxNumChanges = 1000;
constexpr int64_t kMaxWaitS = 30;
constexpr std::chrono::milliseconds kLookPeriod{250};
constexpr int64_t kForgetPeriodUs = 3'600'000'000;

int64_t WholeIn(const Call& call, const char* name, int64_t otherwise, int64_t min, int64_t max) {
  const std::optional<int64_t> value = call.QueryInteger(name);
  if (!value) return otherwise;
  if (*value >= min && *value <= max) return *value;
  const std::string rule =
      "must be a whole number, " + std::to_string(min) + " to " + std::to_string(max);
  throw ApiError("InvalidValue", std::string(name) + ": " + rule, {{name, rule}});
}

std::set<ChangeSubject> SubjectsIn(const Call& call) {
  std::set<ChangeSubject> subjects;
  std::istringstream words(call.Query("subjects").value_or(""));
  for (std::string word; std::getline(words, word, ',');) {
    const std::optional<ChangeSubject> subject = SubjectOfWord(word);
    if (subject) {
      subjects.insert(*subject);
      continue;
    }
    const std::string detail = "subjects: must be of site, map and obstacle";
    throw ApiError("InvalidQuery", detail, {{"subjects", detail}});
  }
  return subjects;
}

// Waits in one of few threads; others are answered at once.
void AwaitNews(Service& service, const Call& call, int64_t after_number, int64_t wait_s) {
  if (wait_s == 0 || !service.change_waiters.try_acquire()) return;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(wait_s);
  while (std::chrono::steady_clock::now() < until && !service.intake.is_stopping &&
         !call.body.HasClientLeft() && service.storage.changes.LastNumber() <= after_number) {
    std::this_thread::sleep_for(kLookPeriod);
  }
  service.change_waiters.release();
}

// Once an hour, when somebody asks.
void ForgetOldRemovals(Service& service) {
  const int64_t now_us = NowUs();
  int64_t last_us = service.removals_forgotten_at_us;
  if (now_us - last_us < kForgetPeriodUs) return;
  if (!service.removals_forgotten_at_us.compare_exchange_strong(last_us, now_us)) return;
  service.storage.changes.ForgetRemoved(now_us - kRemovalsKeptDays * 24 * kForgetPeriodUs);
}

std::string MapIdOf(const Call& call) { return call.Id("flight") + "/" + call.Id("number"); }

void PublishSites(Service& service, const std::vector<SiteRow>& sites) {
  for (const SiteRow& site : sites) {
    service.events.Publish("site",
                           site.flight_id,
                           nlohmann::json{{"id", site.id}, {"flight_id", site.flight_id}}.dump());
  }
  service.alternates.WakeAll();
}

}  // namespace

void GetChanges(Service& service, const Call& call, httplib::Response& response) {
  FeedRequest request;
  request.since = ParseFeedPlace(call.Query("since").value_or("0"));
  request.area = ParseBoundingBox(call);
  request.subjects = SubjectsIn(call);
  request.limit = static_cast<size_t>(
      WholeIn(call, "limit", static_cast<int64_t>(request.limit), 1, kMaxNumChanges));
  const int64_t wait_s = WholeIn(call, "wait_s", 0, 0, kMaxWaitS);
  ForgetOldRemovals(service);
  nlohmann::json page = FeedPage(service.storage, request);
  if (page["changes"].empty() && !page["has_more"].get<bool>() && wait_s > 0) {
    const FeedPlace next = ParseFeedPlace(page["next"].get<std::string>());
    AwaitNews(service, call, next.number, wait_s);
    page = FeedPage(service.storage, request);
  }
  response.set_content(page.dump(), "application/json");
}

void PostChanges(Service& service, const Call& call, httplib::Response& response) {
  constexpr size_t kMaxBytes = kLimits.following.max_changes_bytes;
  const nlohmann::json body = ParseJson(call.body.ReadAll(kMaxBytes), kMaxBytes);
  const auto found = body.find("changes");
  if (!body.is_object() || found == body.end() || !found->is_array()) {
    throw ApiError("InvalidValue", "changes: must be an array", {{"/changes", "must be an array"}});
  }
  std::vector<ToldChange> changes;
  for (size_t i = 0; i < found->size(); ++i) {
    const std::string pointer = "/changes/" + std::to_string(i);
    changes.push_back(ParseTold((*found)[i], pointer));
    if (changes.back().has_left) {
      throw ApiError("InvalidValue", "left: is for followers", {{pointer + "/change", "is left"}});
    }
  }
  const MergeResult merged = [&] {
    const std::lock_guard lock(service.obstacles_mutex);
    return MergeFromBelow(service.storage, service.maps, changes);
  }();
  PublishSites(service, merged.sites);
  response.set_content(nlohmann::json{{"num_taken", merged.num_taken}}.dump(), "application/json");
}

void GetStoredMap(Service& service, const Call& call, httplib::Response& response) {
  const std::optional<FlightMapRow> map = service.storage.maps.Find(MapIdOf(call));
  if (!map) throw ApiError("NoMap", "there is no such map");
  const LongPlace place(service.long_queues.files, WantedBy(service, call));
  const std::string bytes = MapBytes(service.storage, *map);
  const std::string etag = "\"" + Sha256Hex(bytes) + "\"";
  response.set_header("ETag", etag);
  response.set_header("Cache-Control", "private, max-age=31536000, immutable");
  if (call.request.get_header_value("If-None-Match") == etag) {
    response.status = 304;
    return;
  }
  response.set_content(bytes, "application/octet-stream");
}

void PutStoredMap(Service& service, const Call& call, httplib::Response& response) {
  const std::string id = MapIdOf(call);
  const std::string bytes = call.body.ReadAll(kLimits.following.max_map_bytes);
  CheckDigest(call.request.get_header_value("Repr-Digest"), {Sha256Hex(bytes)});
  const TakenMap taken = ParseMapBytes(bytes, id);
  const std::optional<FlightMapRow> known = service.storage.maps.Find(id);
  if (known && known->updated_at_us != taken.map.updated_at_us) {
    throw ApiError("Conflict", "another map has this id");
  }
  if (!known) service.storage.maps.Stage(taken.map, taken.tiles, {});
  response.status = known ? 200 : 201;
  response.set_content(nlohmann::json{{"id", id}}.dump(), "application/json");
}

}  // namespace freelsd
