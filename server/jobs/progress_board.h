// What the worker does now and how fast, for people who wait. Nothing of it is stored: after a
// restart it is unknown until the work goes on.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "server/jobs/time_left.h"

namespace freelsd {

// kFinish: all regions, for a job. kPeriodic: the best regions of a live flight, without a job.
// kReplay: a finish again, with its frames.
enum class EvaluationKind { kFinish, kPeriodic, kReplay };

struct EvaluationNow {
  std::string flight_id;
  // Empty if the evaluation belongs to no job.
  std::string job_id;
  std::optional<double> time_left_s;
  // The ground that is evaluated, as a GeoJSON Polygon; empty until it is known.
  std::string area_json;
};

struct JobTiming {
  int64_t started_at_us = 0;
  // Nothing while unknown, and for a job that has ended.
  std::optional<double> time_left_s;
};

// Thread-safe.
class ProgressBoard {
 public:
  using Clock = std::chrono::steady_clock;

  // --- Backend thread: one evaluation at a time ---
  void BeginEvaluation(EvaluationKind kind,
                       const std::string& flight_id,
                       const std::string& job_id,
                       int64_t num_frames);
  void TellEvaluation(double done_ratio);
  // A GeoJSON Polygon.
  void SetArea(const std::string& area_json);
  // `is_complete`: the evaluation was neither cancelled nor failed, so its duration tells how long
  // others will take.
  void EndEvaluation(bool is_complete);

  // --- Frontend thread ---
  // The progress of a batch. The first call with progress is its start.
  void TellBatch(const std::string& job_id, double done_ratio);
  // A frame took this time.
  void AddFrameTime(double seconds);

  // --- Both ---
  // Why no job can go on: a sentence, or nothing if they can.
  void SetHeld(const std::optional<std::string>& why);

  // --- All threads ---
  std::optional<std::string> WhyHeld() const;
  std::optional<EvaluationNow> Evaluating() const;
  // Nothing if the job has not begun since the program started.
  std::optional<JobTiming> TimingOf(const std::string& job_id) const;
  // How long such an evaluation of that many frames took lately, per frame; nothing if there was
  // none.
  std::optional<double> ExpectedEvaluationS(EvaluationKind kind, int64_t num_frames) const;
  // How long one frame took in the frontend lately.
  std::optional<double> FrameTimeS() const;

 private:
  struct Evaluation {
    EvaluationKind kind;
    EvaluationNow now;
    int64_t num_frames;
    double begin_s;
    TimeLeft time_left;
  };
  struct Job {
    int64_t started_at_us;
    std::optional<TimeLeft> time_left;
  };
  std::optional<double> ExpectedS(EvaluationKind kind, int64_t num_frames) const;
  Job& NewJob(const std::string& job_id);

  // Guards all members below. At of a TimeLeft changes it.
  mutable std::mutex mutex_;
  std::optional<std::string> why_held_;
  mutable std::optional<Evaluation> evaluation_;
  mutable std::map<std::string, Job> jobs_;
  // The keys of jobs_, in the order in which the jobs began.
  std::deque<std::string> begun_;
  std::map<EvaluationKind, double> evaluation_s_per_frame_;
  std::optional<double> frame_s_;
};

// An evaluation on the board, for as long as this object exists.
class EvaluationMark {
 public:
  EvaluationMark(ProgressBoard& board,
                 EvaluationKind kind,
                 const std::string& flight_id,
                 const std::string& job_id,
                 int64_t num_frames)
      : board_(board) {
    board_.BeginEvaluation(kind, flight_id, job_id, num_frames);
  }
  ~EvaluationMark() { board_.EndEvaluation(is_complete); }
  EvaluationMark(const EvaluationMark&) = delete;
  EvaluationMark& operator=(const EvaluationMark&) = delete;

  bool is_complete = false;

 private:
  ProgressBoard& board_;
};

}  // namespace freelsd
