#include "server/jobs/flight_session.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "server/intake/intake.h"

namespace freelsd {

FlightSession::FlightSession(const FlightRow& flight, const GroundModels& ground_models)
    : flight_id_(flight.id),
      request_(ParseStoredFlightRequest(flight.request_json)),
      rig_(ParseStoredFlightRig(flight.rig_json)),
      model_digest_(ground_models.DigestFor(request_.options.preset)),
      local_frame_(rig_.origin),
      frontend_(rig_.rig, request_.options, ground_models.For(request_.options.preset)) {}

FlightContext FlightSession::Context() const {
  return {flight_id_, request_.altitude_datum.value_or("unknown"), local_frame_};
}

// The wind at the time of a frame is part of the frame.
void FlightSession::GiveWinds(const Storage& storage, const Config& config, const FrameMeta& next) {
  if (!next.timestamp_us) return;
  if (last_frame_us_) {
    const auto winds =
        WindsBetween(storage, config, flight_id_, *last_frame_us_, *next.timestamp_us);
    const std::lock_guard lock(frontend_mutex_);
    for (const MeasuredWind& wind : winds) {
      frontend_.AddWind(
          {local_frame_.WorldFromGeo(wind.place), wind.wind_in_world, wind.timestamp_us});
    }
  }
  last_frame_us_ = std::max(last_frame_us_.value_or(*next.timestamp_us), *next.timestamp_us);
}

std::vector<FrameResult> FlightSession::Give(const FrameRow& row,
                                             const FrameMeta& meta,
                                             const cv::Mat& image) {
  // A frame without a timestamp gets its sequence number instead.
  Frame frame = MakeFrame(row.id, image, meta, rig_.rig, local_frame_, row.sequence);
  const std::lock_guard lock(frontend_mutex_);
  times_[row.id] = CaptureTimeOf(row, meta);
  std::vector<FrameResult> results = frontend_.Process(std::move(frame));
  AddReports(frontend_.TakeReports());
  cursor_ = row.sequence;
  ++num_steps_;
  has_unstored_results_ = has_unstored_results_ || !results.empty();
  return results;
}

std::vector<FrameResult> FlightSession::Flush(int64_t through_sequence) {
  const std::lock_guard lock(frontend_mutex_);
  std::vector<FrameResult> results = frontend_.Flush();
  AddReports(frontend_.TakeReports());
  std::erase_if(flush_points_, [&](int64_t sequence) { return sequence <= through_sequence; });
  if (!results.empty()) first_settled_at_ = std::min(first_settled_at_.load(), through_sequence);
  ++num_steps_;
  // Before a finish that waits for this flush sees it.
  has_unstored_results_ = has_unstored_results_ || !results.empty();
  flushed_through_ = through_sequence;
  return results;
}

void FlightSession::AddFlushPoint(int64_t sequence) {
  if (sequence > flushed_through_) flush_points_.insert(sequence);
}

std::optional<int64_t> FlightSession::NextFlushPoint() const {
  if (flush_points_.empty()) return std::nullopt;
  return *flush_points_.begin();
}

void FlightSession::StoreResults(const std::vector<FrameResult>& results,
                                 const std::function<void(const FrameResult&)>& store) {
  {
    const std::lock_guard lock(statistics_mutex_);
    for (const FrameResult& result : results) {
      if (result.note.empty()) continue;
      NoteCount& note = notes_[result.note];
      if (note.count++ == 0) note.first_frame_id = result.frame_id;
    }
  }
  unstored_results_.insert(unstored_results_.end(), results.begin(), results.end());
  has_unstored_results_ = !unstored_results_.empty();
  while (!unstored_results_.empty()) {
    store(unstored_results_.front());
    unstored_results_.pop_front();
  }
  has_unstored_results_ = false;
}

std::pair<Snapshot, int64_t> FlightSession::TakeSnapshot() {
  const std::lock_guard lock(frontend_mutex_);
  return {frontend_.TakeSnapshot(), cursor_};
}

CaptureTimes FlightSession::TimesOfFrames() {
  const std::lock_guard lock(frontend_mutex_);
  return times_;
}

void FlightSession::AddReports(const std::vector<StageReport>& reports) {
  const std::lock_guard lock(statistics_mutex_);
  for (const StageReport& report : reports) {
    StageSum& sum = stages_[report.stage];
    sum.seconds += report.seconds;
    sum.count += std::max<int64_t>(report.count, 1);
  }
}

// Stages that this session has not run keep their stored values.
std::string FlightSession::StagesJson(const std::string& stored_json) {
  nlohmann::json stages = nlohmann::json::parse(stored_json);
  const std::lock_guard lock(statistics_mutex_);
  for (const auto& [name, sum] : stages_) {
    stages[name] = {{"mean_ms", 1000.0 * sum.seconds / static_cast<double>(sum.count)},
                    {"count", sum.count}};
  }
  return stages.dump();
}

std::vector<std::string> FlightSession::NoteSentences() {
  const std::lock_guard lock(statistics_mutex_);
  std::vector<std::string> sentences;
  for (const auto& [text, note] : notes_) {
    sentences.push_back(text + (note.count == 1
                                    ? " (frame " + note.first_frame_id + ")"
                                    : " (" + std::to_string(note.count) + " frames, first " +
                                          note.first_frame_id + ")"));
  }
  return sentences;
}

void FlightSession::StoreRegions(Storage& storage) {
  std::vector<Candidate> regions;
  {
    const std::lock_guard lock(frontend_mutex_);
    regions = frontend_.RankedRegions();
  }
  const FlightContext context = Context();
  std::vector<RegionRow> rows;
  rows.reserve(regions.size());
  for (const auto& [region, wind] : regions) {
    rows.push_back(
        {region.id, RegionFeature(region, wind, context).dump(), RegionHistoryJson(region).dump()});
  }
  storage.flights.ReplaceRegions(flight_id_, rows);
}

void FlightSession::Store(Storage& storage) {
  // The frontend may go on meanwhile.
  const int64_t num_steps = num_steps_;
  StoreRegions(storage);
  std::optional<double> ground_altitude_m;
  {
    const std::lock_guard lock(frontend_mutex_);
    if (const auto height = frontend_.GroundHeight()) {
      ground_altitude_m = rig_.origin.altitude_m + *height;
    }
  }
  storage.flights.Change(flight_id_, [&](FlightRow& flight) {
    flight.stages_json = StagesJson(flight.stages_json);
    flight.warnings_json = ReplaceWarnings(flight.warnings_json, "frames", NoteSentences());
    if (ground_altitude_m) flight.ground_altitude_m = ground_altitude_m;
  });
  num_stored_steps_ = num_steps;
}

}  // namespace freelsd
