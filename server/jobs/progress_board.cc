#include "server/jobs/progress_board.h"

#include "server/http/http.h"

namespace freelsd {
namespace {

// Most jobs whose start is remembered.
constexpr size_t kMaxNumJobs = 1000;
// Weight of the latest duration in the mean of the earlier ones.
constexpr double kNewWeight = 0.5;
// The same for a frame: there are many of them.
constexpr double kNewFrameWeight = 0.1;

double NowS() {
  return std::chrono::duration<double>(ProgressBoard::Clock::now().time_since_epoch()).count();
}

}  // namespace

ProgressBoard::Job& ProgressBoard::NewJob(const std::string& job_id) {
  const auto [place, is_new] = jobs_.emplace(job_id, Job{NowUs(), std::nullopt});
  if (is_new) begun_.push_back(job_id);
  if (begun_.size() > kMaxNumJobs) {
    jobs_.erase(begun_.front());
    begun_.pop_front();
  }
  return place->second;
}

std::optional<double> ProgressBoard::ExpectedS(EvaluationKind kind, int64_t num_frames) const {
  const auto found = evaluation_s_per_frame_.find(kind);
  if (found == evaluation_s_per_frame_.end()) return std::nullopt;
  return found->second * static_cast<double>(num_frames);
}

void ProgressBoard::BeginEvaluation(EvaluationKind kind,
                                    const std::string& flight_id,
                                    const std::string& job_id,
                                    int64_t num_frames) {
  const std::lock_guard lock(mutex_);
  const double now_s = NowS();
  evaluation_.emplace(Evaluation{kind,
                                 {flight_id, job_id, std::nullopt, ""},
                                 num_frames,
                                 now_s,
                                 TimeLeft(now_s, 0.0, ExpectedS(kind, num_frames))});
  if (!job_id.empty()) NewJob(job_id);
}

void ProgressBoard::TellEvaluation(double done_ratio) {
  const std::lock_guard lock(mutex_);
  if (evaluation_) evaluation_->time_left.Add(NowS(), done_ratio);
}

void ProgressBoard::SetHeld(const std::optional<std::string>& why) {
  const std::lock_guard lock(mutex_);
  why_held_ = why;
}

std::optional<std::string> ProgressBoard::WhyHeld() const {
  const std::lock_guard lock(mutex_);
  return why_held_;
}

void ProgressBoard::SetArea(const std::string& area_json) {
  const std::lock_guard lock(mutex_);
  if (evaluation_) evaluation_->now.area_json = area_json;
}

void ProgressBoard::EndEvaluation(bool is_complete) {
  const std::lock_guard lock(mutex_);
  if (!evaluation_) return;
  if (is_complete && evaluation_->num_frames > 0) {
    const double s_per_frame =
        (NowS() - evaluation_->begin_s) / static_cast<double>(evaluation_->num_frames);
    auto& mean = evaluation_s_per_frame_.emplace(evaluation_->kind, s_per_frame).first->second;
    mean += kNewWeight * (s_per_frame - mean);
  }
  evaluation_.reset();
}

void ProgressBoard::TellBatch(const std::string& job_id, double done_ratio) {
  if (!(done_ratio > 0.0)) return;
  const std::lock_guard lock(mutex_);
  auto found = jobs_.find(job_id);
  if (found == jobs_.end()) {
    NewJob(job_id).time_left.emplace(NowS(), done_ratio);
    return;
  }
  if (found->second.time_left) found->second.time_left->Add(NowS(), done_ratio);
}

void ProgressBoard::AddFrameTime(double seconds) {
  const std::lock_guard lock(mutex_);
  frame_s_ = frame_s_ ? *frame_s_ + kNewFrameWeight * (seconds - *frame_s_) : seconds;
}

std::optional<EvaluationNow> ProgressBoard::Evaluating() const {
  const std::lock_guard lock(mutex_);
  if (!evaluation_) return std::nullopt;
  EvaluationNow now = evaluation_->now;
  now.time_left_s = evaluation_->time_left.At(NowS());
  return now;
}

std::optional<JobTiming> ProgressBoard::TimingOf(const std::string& job_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = jobs_.find(job_id);
  if (found == jobs_.end()) return std::nullopt;
  JobTiming timing{found->second.started_at_us, std::nullopt};
  if (evaluation_ && evaluation_->now.job_id == job_id) {
    timing.time_left_s = evaluation_->time_left.At(NowS());
  } else if (found->second.time_left) {
    timing.time_left_s = found->second.time_left->At(NowS());
  }
  return timing;
}

std::optional<double> ProgressBoard::ExpectedEvaluationS(EvaluationKind kind,
                                                         int64_t num_frames) const {
  const std::lock_guard lock(mutex_);
  return ExpectedS(kind, num_frames);
}

std::optional<double> ProgressBoard::FrameTimeS() const {
  const std::lock_guard lock(mutex_);
  return frame_s_;
}

}  // namespace freelsd
