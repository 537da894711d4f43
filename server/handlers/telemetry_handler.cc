#include <array>
#include <chrono>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

// Samples are committed together; this is the longest delay.
constexpr std::chrono::milliseconds kCommitPeriod{200};
constexpr size_t kMaxNumRowsTogether = 2000;

// Takes lines as they arrive. Finish commits all samples that are counted as accepted.
class TelemetryIntake {
 public:
  TelemetryIntake(Intake& intake, const std::string& flight_id)
      : intake_(intake), flight_id_(flight_id) {}

  void Take(std::string line) {
    ++line_number_;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") == std::string::npos) return;
    try {
      std::vector<TelemetryRow> rows = ParseTelemetryLine(line);
      if (!rows.empty()) RefuseFutureTime(rows.front().timestamp_us, NowUs());
      for (TelemetryRow& row : rows) row.arrived_at_us = ArrivalNowUs();
      rows_.insert(rows_.end(), rows.begin(), rows.end());
      ++num_accepted_;
    } catch (const ApiError& error) {
      Reject(error.what());
    }
  }
  void TakeTooLong() {
    ++line_number_;
    Reject("the line is longer than " + std::to_string(kLimits.stream.max_telemetry_line_bytes) +
           " bytes");
  }
  void CommitWhenDue() {
    const auto now = std::chrono::steady_clock::now();
    if (rows_.size() < kMaxNumRowsTogether && now - committed_at_ < kCommitPeriod) return;
    Commit();
    committed_at_ = now;
  }
  void Commit() {
    if (rows_.empty()) return;
    const bool has_flight = intake_.storage.telemetry.Put(flight_id_, rows_);
    rows_.clear();
    if (!has_flight) throw ApiError("NoSuchFlight", "the flight was deleted");
    intake_.wake_worker();
    intake_.on_new_pose(flight_id_);
  }
  nlohmann::json Answer() const {
    nlohmann::json answer{{"accepted", num_accepted_}, {"rejected", rejected_}};
    if (num_rejected_ > rejected_.size()) answer["num_rejected"] = num_rejected_;
    return answer;
  }

 private:
  void Reject(const std::string& detail) {
    ++num_rejected_;
    if (rejected_.size() >= kLimits.answer.max_num_listed_rejections) return;
    rejected_.push_back({{"line", line_number_}, {"detail", detail}});
  }

  Intake& intake_;
  std::string flight_id_;
  std::vector<TelemetryRow> rows_;
  int64_t line_number_ = 0;
  int64_t num_accepted_ = 0;
  size_t num_rejected_ = 0;
  nlohmann::json rejected_ = nlohmann::json::array();
  std::chrono::steady_clock::time_point committed_at_{};
};

// Takes all complete lines out of `text`.
void TakeLines(std::string& text, bool& is_skipping, TelemetryIntake& intake) {
  size_t begin = 0;
  for (size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (!is_skipping) intake.Take(text.substr(begin, end - begin));
    is_skipping = false;
  }
  text.erase(0, begin);
  if (text.size() <= kLimits.stream.max_telemetry_line_bytes) return;
  if (!is_skipping) intake.TakeTooLong();
  is_skipping = true;
  text.clear();
}

}  // namespace

void PostTelemetry(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  const Streaming streaming(service.intake, flight_id);
  TelemetryIntake telemetry(service.intake, flight_id);
  call.body.LimitTo(kLimits.stream.max_telemetry_bytes);
  call.body.WaitFor(std::chrono::seconds(kLimits.stream.max_pause_s));
  std::string text;
  bool is_skipping = false;
  std::array<char, 16384> bytes;
  try {
    while (const size_t num_read = call.body.Read(bytes.data(), bytes.size())) {
      text.append(bytes.data(), num_read);
      TakeLines(text, is_skipping, telemetry);
      telemetry.CommitWhenDue();
    }
    if (!text.empty() && !is_skipping) telemetry.Take(text);
  } catch (const ApiError&) {
    // Samples that arrived before a lost connection are kept.
    telemetry.Commit();
    throw;
  }
  telemetry.Commit();
  response.set_content(telemetry.Answer().dump(), "application/json");
}

}  // namespace freelsd
