#include <algorithm>
#include <sstream>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "engine/glide/glide.h"
#include "engine/obstacles/obstacles.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/recall/recall.h"

namespace freelsd {

void GetHealth(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json health{{"status", "ok"}};
  if (service.copy.IsThere()) health["copy"] = service.copy.Json(NowUs());
  response.set_content(health.dump(), "application/json");
}

namespace {

// Messages about a damaged database may hold bytes of it, which need not be UTF-8.
std::string TextOf(const nlohmann::json& answer) {
  return answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void GetReadiness(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json reasons = nlohmann::json::array();
  if (service.intake.is_stopping) reasons.push_back("the server is stopping");
  if (const auto reason = service.storage.WhyNotWritable())
    reasons.push_back("storage: " + *reason);
  const bool is_ready = reasons.empty();
  const std::vector<std::string> notices = service.storage.Notices();
  if (is_ready) {
    const nlohmann::json answer{{"ready", true}, {"reasons", reasons}, {"notices", notices}};
    response.set_content(TextOf(answer), "application/json");
    return;
  }
  nlohmann::json problem = nlohmann::json::parse(
      ProblemJson(ApiError("Unavailable", "the server cannot accept work now")));
  problem["ready"] = false;
  problem["reasons"] = reasons;
  problem["notices"] = notices;
  response.status = 503;
  response.set_content(TextOf(problem), "application/problem+json");
  response.set_header("Retry-After", std::to_string(RetryAfterSeconds("Unavailable").value_or(1)));
}

namespace {

nlohmann::json NoticeJson(const Notice& notice) {
  nlohmann::json json{{"id", notice.id},
                      {"text", notice.text},
                      {"raised_at", Rfc3339(notice.raised_at_us)},
                      {"acknowledged_at", nullptr}};
  if (notice.acknowledged_at_us) json["acknowledged_at"] = Rfc3339(*notice.acknowledged_at_us);
  return json;
}

}  // namespace

void GetNotices(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json notices = nlohmann::json::array();
  for (const Notice& notice : service.storage.ListNotices()) notices.push_back(NoticeJson(notice));
  response.set_content(nlohmann::json{{"notices", notices}}.dump(), "application/json");
}

// Answers the notice. Recall no longer warns of it.
void PostAcknowledgement(Service& service, const Call& call, httplib::Response& response) {
  const std::string& id = call.Id("notice");
  if (!service.storage.AcknowledgeNotice(id)) {
    throw ApiError("NoSuchNotice", "there is no such notice");
  }
  service.alternates.WakeAll();
  for (const Notice& notice : service.storage.ListNotices()) {
    if (notice.id == id) response.set_content(NoticeJson(notice).dump(), "application/json");
  }
}

namespace {

template <typename Value>
void WriteGauge(std::ostream& text, const char* name, const char* help, Value value) {
  text << "# HELP freelsd_" << name << ' ' << help << "\n# TYPE freelsd_" << name
       << " gauge\nfreelsd_" << name << ' ' << value << '\n';
}

// 0 where nothing waits.
double AgeOf(const std::optional<int64_t>& since_us) {
  constexpr double kUsPerS = 1e6;
  if (!since_us) return 0.0;
  return std::max(0.0, static_cast<double>(NowUs() - *since_us) / kUsPerS);
}

void WriteQueues(std::ostream& text, const Storage& storage) {
  WriteGauge(
      text, "queued_frames", "Frames that wait for the engine.", storage.frames.CountQueued());
  WriteGauge(text,
             "oldest_queued_frame_seconds",
             "Age of the frame that waits longest, frames of batches included.",
             AgeOf(storage.frames.OldestQueuedArrival()));
  const std::vector<JobRow> jobs = storage.jobs.ListUnfinished();
  WriteGauge(text, "unfinished_jobs", "Jobs queued or running.", jobs.size());
  const auto queued = std::find_if(
      jobs.begin(), jobs.end(), [](const JobRow& job) { return job.state == JobState::kQueued; });
  WriteGauge(text,
             "oldest_queued_job_seconds",
             "Age of the job that waits longest.",
             queued == jobs.end() ? 0.0 : AgeOf(queued->created_at_us));
}

void WriteLeases(std::ostream& text, const Storage& storage) {
  if (!storage.claims.IsShared()) return;
  const LeaseCounts counts = storage.claims.CountLeases();
  WriteGauge(text, "workers", "Workers whose lease goes on.", counts.num_workers);
  WriteGauge(text,
             "expired_workers",
             "Workers whose lease is over and whose flights nobody has taken yet.",
             counts.num_expired_workers);
  WriteGauge(
      text, "claimed_flights", "Flights that a worker works on.", counts.num_claimed_flights);
  WriteGauge(
      text, "waiting_flights", "Flights that have work and no worker.", counts.num_waiting_flights);
}

void WritePools(std::ostream& text, const std::vector<PoolState>& pools) {
  if (pools.empty()) return;
  const auto of_each = [&](const char* name, const char* kind, const char* help, auto value_of) {
    text << "# HELP freelsd_database_" << name << ' ' << help << "\n# TYPE freelsd_database_"
         << name << ' ' << kind << '\n';
    for (const PoolState& pool : pools) {
      text << "freelsd_database_" << name << "{pool=\"" << pool.name << "\"} " << value_of(pool)
           << '\n';
    }
  };
  of_each("connections", "gauge", "Open connections of this server.", [](const PoolState& pool) {
    return pool.num_open;
  });
  of_each("connections_in_use", "gauge", "Those that are in use.", [](const PoolState& pool) {
    return pool.num_in_use;
  });
  of_each("max_connections", "gauge", "Most that this server opens.", [](const PoolState& pool) {
    return pool.max_num_connections;
  });
  of_each("waits_total", "counter", "How often all were in use.", [](const PoolState& pool) {
    return pool.num_waits;
  });
  of_each("waited_seconds_total", "counter", "Time waited for one.", [](const PoolState& pool) {
    return pool.waited_s;
  });
}

}  // namespace

// Gauges are read from storage for each request, so that they agree with it.
void GetMetrics(Service& service, const Call&, httplib::Response& response) {
  std::ostringstream text;
  const auto gauge = [&text](const char* name, const char* help, auto value) {
    WriteGauge(text, name, help, value);
  };
  WriteQueues(text, service.storage);
  WriteLeases(text, service.storage);
  gauge("flights", "Stored flights.", service.storage.flights.Count());
  gauge("recallable_sites",
        "Sites that emergency recall may answer with.",
        service.storage.sites.CountRecallable());
  gauge("notices", "Notices for the operator, see /readyz.", service.storage.Notices().size());
  gauge("stored_image_bytes", "Total size of all image files.", service.storage.images.NumBytes());
  gauge(
      "writable", "1 if storage accepts writes, else 0.", service.storage.WhyNotWritable() ? 0 : 1);
  WritePools(text, service.storage.Pools());
  if (const std::optional<double> age_s = service.copy.AgeS(NowUs())) {
    gauge("copy_age_seconds", "Since this copy of the followed server was in step.", *age_s);
  }
  response.set_content(text.str() + service.metrics.Text(), "text/plain; version=0.0.4");
}

namespace {

// All limits of the service: the fixed ones, and those that an operator sets.
nlohmann::json LimitsOf(const Service& service) {
  const Config& config = service.config;
  nlohmann::json limits = LimitsJson(kLimits);
  limits.update(
      nlohmann::json{{"max_batch_bytes", config.max_batch_bytes},
                     {"max_telemetry_gap_s", config.max_telemetry_gap_s},
                     {"max_telemetry_extrapolation_s", config.max_telemetry_extrapolation_s},
                     {"telemetry_wait_s", config.telemetry_wait_s},
                     {"max_num_streams", MaxNumStreams(config)},
                     {"max_num_queued_frames", config.max_num_queued_frames},
                     {"max_num_open_flights", config.max_num_open_flights},
                     {"num_alternates", config.num_alternates},
                     {"num_http_threads", config.num_http_threads},
                     {"max_image_age_days", config.max_image_age_days},
                     {"max_stored_image_bytes", config.max_stored_image_bytes}});
  return limits;
}

nlohmann::json EmergencyInfo() {
  const GlideOptions options;
  return {{"unknown_wind_mps", options.unknown_wind_mps},
          {"datum_penalty_m", options.datum_penalty_m},
          {"terrain_clearance_m", options.terrain_clearance_m},
          {"max_surplus_m", options.max_surplus_m},
          {"max_shortfall_m", options.max_shortfall_m}};
}

nlohmann::json ObstaclesInfo() {
  const ObstacleOptions options;
  return {{"position_sigma", options.position_sigma},
          {"min_height_m", options.min_height_m},
          {"people_height_m", options.people_height_m}};
}

}  // namespace

void GetInfo(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json info = OptionsJson();
  info["name"] = "freelsd";
  info["version"] = FREELSD_VERSION;
  info["database"] = service.storage.Kind() == DatabaseKind::kSqlite ? "sqlite" : "postgresql";
  info["limits"] = LimitsOf(service);
  info["emergency"] = EmergencyInfo();
  info["obstacles"] = ObstaclesInfo();
  info["has_base_map"] = !service.base_map.TileJson().is_null();
  if (const std::string& problem = service.base_map.problem(); !problem.empty()) {
    info["base_map_problem"] = problem;
  }
  response.set_content(info.dump(), "application/json");
}

void GetOpenApi(Service&, const Call&, httplib::Response& response) {
  response.set_content(std::string(OpenApiJson()), "application/json");
}

}  // namespace freelsd
