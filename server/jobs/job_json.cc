#include "server/jobs/job_json.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "server/http/http.h"
#include "server/jobs/job_words.h"

namespace freelsd {
namespace {

constexpr const char* kStateNames[] = {"queued", "running", "done", "failed", "cancelled"};

// Whole tenths of seconds; null if unknown.
nlohmann::json SecondsJson(std::optional<double> seconds) {
  if (!seconds) return nullptr;
  return std::round(*seconds * 10.0) / 10.0;
}

std::string WithTime(const std::string& words, std::optional<double> seconds) {
  return seconds ? words + ", " + AboutTime(*seconds) : words;
}

nlohmann::json LinksOf(const JobRow& job) {
  const std::string flight = "/v1/flights/" + job.flight_id;
  nlohmann::json result{{"flight", flight}};
  if (job.kind == "finish") result["sites"] = flight + "/sites";
  if (job.kind == "batch") result["frames"] = flight + "/frames";
  return result;
}

// "5 places were evaluated".
std::string NumberDone(int64_t number, const std::string& what, const std::string& done) {
  return std::to_string(number) + " " + what + (number == 1 ? " was " : "s were ") + done;
}

std::string SummaryOfDone(const nlohmann::json& detail) {
  if (detail.contains("message")) return "Done: " + detail.value("message", "");
  if (detail.contains("num_equal")) {
    return "Done: " + std::to_string(detail.value("num_equal", 0)) + " of " +
           std::to_string(detail["sites"].size()) + " sites have the same digest again";
  }
  if (detail.contains("num_sites")) {
    return "Done: " + NumberDone(detail.value("num_sites", int64_t{0}), "place", "evaluated");
  }
  if (detail.contains("num_accepted")) {
    return "Done: " +
           NumberDone(detail.value("num_accepted", int64_t{0}), "photograph", "processed");
  }
  return "Done: nothing new had to be evaluated";
}

std::optional<double> Sum(std::optional<double> a, std::optional<double> b) {
  if (!a || !b) return std::nullopt;
  return *a + *b;
}

}  // namespace

JobView::JobView(const Service& service)
    : service_(service),
      why_held_(service.progress.WhyHeld()),
      evaluation_(service.progress.Evaluating()) {}

nlohmann::json JobView::Json(const JobRow& job) {
  const Outlook outlook = OutlookOf(job);
  const std::optional<JobTiming> timing = service_.progress.TimingOf(job.id);
  const bool is_evaluated = evaluation_ && evaluation_->job_id == job.id;
  const bool is_held = IsUnfinished(job) && why_held_;
  const JobState state = is_held ? JobState::kQueued : job.state;
  nlohmann::json json{{"id", job.id},
                      {"kind", job.kind},
                      {"flight_id", job.flight_id},
                      {"state", kStateNames[static_cast<int>(state)]},
                      {"progress", job.progress_ratio},
                      {"stage", job.stage},
                      {"stage_title", outlook.stage_title},
                      {"summary", outlook.summary},
                      {"time_left_s", SecondsJson(outlook.time_left_s)},
                      {"waiting_for", nullptr},
                      {"area", nullptr},
                      {"detail", nlohmann::json::parse(job.detail_json)},
                      {"result", LinksOf(job)},
                      {"created_at", Rfc3339(job.created_at_us)},
                      {"started_at", nullptr}};
  if (is_held) json["detail"]["message"] = *why_held_;
  if (timing) json["started_at"] = Rfc3339(timing->started_at_us);
  if (outlook.waits_for_evaluation) {
    json["waiting_for"] = {{"flight_id", evaluation_->flight_id},
                           {"flight_name", NameOfEvaluated()},
                           {"time_left_s", SecondsJson(evaluation_->time_left_s)}};
  }
  if (is_evaluated && IsUnfinished(job) && !evaluation_->area_json.empty()) {
    json["area"] = nlohmann::json::parse(evaluation_->area_json);
  }
  return json;
}

// Another server works on it, which alone knows how long it takes.
bool JobView::RunsElsewhere(const JobRow& job) const {
  const bool is_evaluated = evaluation_ && evaluation_->job_id == job.id;
  return job.state == JobState::kRunning && service_.storage.claims.IsShared() && !is_evaluated &&
         !service_.progress.TimingOf(job.id);
}

JobView::Outlook JobView::OutlookOf(const JobRow& job) {
  if (job.state == JobState::kCancelled) return {"Cancelled", "Cancelled", std::nullopt, false};
  if (!IsUnfinished(job)) {
    const nlohmann::json detail = nlohmann::json::parse(job.detail_json);
    if (job.state == JobState::kDone) return {"Done", SummaryOfDone(detail), std::nullopt, false};
    return {"Failed", "Failed: " + detail.value("message", "unknown reason"), std::nullopt, false};
  }
  if (why_held_) return {"Waiting for room on the disk", *why_held_, std::nullopt, false};
  if (RunsElsewhere(job)) return OutlookOfRunning(job, std::nullopt);
  // A job that ran before a restart waits until its work goes on.
  if (job.kind != "batch") {
    const bool is_evaluated = evaluation_ && evaluation_->job_id == job.id;
    return is_evaluated ? OutlookOfRunning(job, evaluation_->time_left_s) : OutlookOfWaiting(job);
  }
  const std::optional<JobTiming> timing = service_.progress.TimingOf(job.id);
  return timing ? OutlookOfRunning(job, timing->time_left_s) : OutlookOfWaiting(job);
}

JobView::Outlook JobView::OutlookOfRunning(const JobRow& job,
                                           std::optional<double> time_left_s) const {
  // A queued job's stage is that of an earlier run.
  const std::string title = StageTitle(job.state == JobState::kRunning ? job.stage : "");
  const std::string summary = WithTime(title, time_left_s) + (time_left_s ? " left" : "");
  return {title, summary, time_left_s, false};
}

JobView::Outlook JobView::OutlookOfWaiting(const JobRow& job) {
  Outlook outlook{"Waiting", "Waiting for its turn", std::nullopt, false};
  // The frames of a batch would have to be searched one by one.
  if (job.kind != "finish") return outlook;
  const int64_t last_sequence = LastSequenceOf(job, service_.storage);
  const std::optional<double> frames_s = FramesLeftS(job.flight_id, last_sequence);
  const std::optional<double> ahead_s = EvaluationsAheadS(job);
  const std::optional<double> own_s =
      service_.progress.ExpectedEvaluationS(EvaluationKind::kFinish, last_sequence);
  if (frames_s != 0.0) {
    outlook.summary = WithTime("Waiting until the photographs are processed", frames_s);
    // Photographs are processed while other flights are evaluated.
    if (frames_s && ahead_s) outlook.time_left_s = Sum(std::max(*frames_s, *ahead_s), own_s);
    return outlook;
  }
  outlook.time_left_s = Sum(ahead_s, own_s);
  if (!evaluation_) return outlook;
  outlook.waits_for_evaluation = evaluation_->flight_id != job.flight_id;
  const std::string what =
      outlook.waits_for_evaluation ? NameOfEvaluated() : "an earlier evaluation of this flight";
  outlook.summary = WithTime("Waiting for " + what, evaluation_->time_left_s);
  return outlook;
}

std::optional<double> JobView::FramesLeftS(const std::string& flight_id, int64_t last_sequence) {
  const auto next = service_.storage.frames.NextQueuedSequence(flight_id, 0);
  if (!next || *next > last_sequence) return 0.0;
  std::set<std::string> flights{flight_id};
  for (const JobRow& job : Unfinished()) {
    if (job.kind == "batch") flights.insert(job.flight_id);
  }
  const std::optional<double> frame_s = service_.progress.FrameTimeS();
  if (!frame_s) return std::nullopt;
  return *frame_s * static_cast<double>(last_sequence - *next + 1) *
         static_cast<double>(flights.size());
}

const std::vector<JobRow>& JobView::Unfinished() {
  if (!unfinished_) unfinished_ = service_.storage.jobs.ListUnfinished();
  return *unfinished_;
}

std::optional<double> JobView::EvaluationsAheadS(const JobRow& job) {
  std::optional<double> ahead_s = evaluation_ ? evaluation_->time_left_s : 0.0;
  for (const JobRow& other : Unfinished()) {
    // Oldest first. A job that was just created has no number yet.
    if (job.number > 0 && other.number >= job.number) break;
    if (other.id == job.id || !ahead_s) break;
    if (other.kind != "finish" || other.flight_id == job.flight_id) continue;
    if (evaluation_ && other.id == evaluation_->job_id) continue;
    ahead_s = Sum(ahead_s,
                  service_.progress.ExpectedEvaluationS(EvaluationKind::kFinish,
                                                        LastSequenceOf(other, service_.storage)));
  }
  return ahead_s;
}

const std::string& JobView::NameOfEvaluated() {
  if (!name_of_evaluated_) {
    const std::optional<FlightRow> flight = service_.storage.flights.Find(evaluation_->flight_id);
    name_of_evaluated_ = flight && !flight->name.empty() ? flight->name : evaluation_->flight_id;
  }
  return *name_of_evaluated_;
}

nlohmann::json JobJson(const Service& service, const JobRow& job) {
  return JobView(service).Json(job);
}

void UpdateJob(Service& service, const JobRow& job) {
  service.storage.jobs.Update(job);
  service.events.Publish("job", job.flight_id, JobJson(service, job).dump());
}

void AnswerJob(const Service& service, const JobRow& job, httplib::Response& response) {
  response.status = 202;
  response.set_header("Location", "/v1/jobs/" + job.id);
  response.set_content(JobJson(service, job).dump(), "application/json");
}

bool IsUnfinished(const JobRow& job) {
  return job.state == JobState::kQueued || job.state == JobState::kRunning;
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
