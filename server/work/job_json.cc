#include "server/work/job_json.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr const char* kStateNames[] = {"queued", "running", "done", "failed", "cancelled"};

}  // namespace

nlohmann::json JobJson(const JobRow& job) {
  const std::string flight = "/v1/flights/" + job.flight_id;
  nlohmann::json result{{"flight", flight}};
  if (job.kind == "finish") result["sites"] = flight + "/sites";
  if (job.kind == "batch") result["frames"] = flight + "/frames";
  return {{"id", job.id},
          {"kind", job.kind},
          {"flight_id", job.flight_id},
          {"state", kStateNames[static_cast<int>(job.state)]},
          {"progress", job.progress_ratio},
          {"stage", job.stage},
          {"detail", nlohmann::json::parse(job.detail_json)},
          {"result", result},
          {"created_at", Rfc3339(job.created_at_us)}};
}

void UpdateJob(Service& service, const JobRow& job) {
  service.storage.jobs.Update(job);
  service.events.Publish("job", job.flight_id, JobJson(job).dump());
}

void AnswerJob(const JobRow& job, httplib::Response& response) {
  response.status = 202;
  response.set_header("Location", "/v1/jobs/" + job.id);
  response.set_content(JobJson(job).dump(), "application/json");
}

int64_t LastSequenceOf(const JobRow& job, const Storage& storage) {
  const nlohmann::json detail = nlohmann::json::parse(job.detail_json);
  if (job.kind == "finish") return detail.value("last_sequence", int64_t{0});
  int64_t last_sequence = 0;
  for (const nlohmann::json& image : detail.value("images", nlohmann::json::array())) {
    const auto frame = storage.frames.Find(job.flight_id, image.value("id", ""));
    if (frame) last_sequence = std::max(last_sequence, frame->sequence);
  }
  return last_sequence;
}

}  // namespace freelsd
