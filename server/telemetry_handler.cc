#include <array>
#include <chrono>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/flight_lookup.h"
#include "server/handlers.h"
#include "server/telemetry.h"

namespace freelsd {
namespace {

constexpr uint64_t kMaxTelemetryBytes = uint64_t{2} << 30;
constexpr size_t kMaxLineBytes = 8 << 10;
constexpr std::chrono::seconds kMaxPause{60};
// Kept samples are committed together, at most this late.
constexpr std::chrono::milliseconds kCommitPeriod{200};
constexpr size_t kMaxNumRowsTogether = 2000;
constexpr size_t kMaxNumListedRejections = 100;

// Takes lines as they come; what it counts as accepted is committed at the latest by Finish.
class TelemetryIntake {
 public:
  TelemetryIntake(Service& service, const std::string& flight_id)
      : service_(service), flight_id_(flight_id) {}

  void Take(std::string line) {
    ++line_number_;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") == std::string::npos) return;
    try {
      for (TelemetryRow& row : ParseTelemetryLine(line)) rows_.push_back(row);
      ++num_accepted_;
    } catch (const ApiError& error) {
      Reject(error.what());
    }
  }
  void TakeTooLong() {
    ++line_number_;
    Reject("the line is longer than " + std::to_string(kMaxLineBytes) + " bytes");
  }
  void CommitWhenDue() {
    const auto now = std::chrono::steady_clock::now();
    if (rows_.size() < kMaxNumRowsTogether && now - committed_at_ < kCommitPeriod) return;
    Commit();
    committed_at_ = now;
  }
  void Commit() {
    if (rows_.empty()) return;
    service_.storage.PutTelemetry(flight_id_, rows_);
    rows_.clear();
    service_.wake_worker();
    service_.alternates.Wake(flight_id_);
  }
  nlohmann::json Answer() const {
    nlohmann::json answer{{"accepted", num_accepted_}, {"rejected", rejected_}};
    if (num_rejected_ > rejected_.size()) answer["num_rejected"] = num_rejected_;
    return answer;
  }

 private:
  void Reject(const std::string& detail) {
    ++num_rejected_;
    if (rejected_.size() >= kMaxNumListedRejections) return;
    rejected_.push_back({{"line", line_number_}, {"detail", detail}});
  }

  Service& service_;
  std::string flight_id_;
  std::vector<TelemetryRow> rows_;
  int64_t line_number_ = 0;
  int64_t num_accepted_ = 0;
  size_t num_rejected_ = 0;
  nlohmann::json rejected_ = nlohmann::json::array();
  std::chrono::steady_clock::time_point committed_at_{};
};

// Whole lines out of what was read so far.
void TakeLines(std::string& text, bool& is_skipping, TelemetryIntake& intake) {
  size_t begin = 0;
  for (size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    if (!is_skipping) intake.Take(text.substr(begin, end - begin));
    is_skipping = false;
  }
  text.erase(0, begin);
  if (text.size() <= kMaxLineBytes) return;
  if (!is_skipping) intake.TakeTooLong();
  is_skipping = true;
  text.clear();
}

}  // namespace

void PostTelemetry(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = ExistingFlight(service, call).id;
  const Streaming streaming(service, flight_id);
  TelemetryIntake intake(service, flight_id);
  call.body.LimitTo(kMaxTelemetryBytes);
  call.body.WaitFor(kMaxPause);
  std::string text;
  bool is_skipping = false;
  std::array<char, 16384> bytes;
  try {
    while (const size_t num_read = call.body.Read(bytes.data(), bytes.size())) {
      text.append(bytes.data(), num_read);
      TakeLines(text, is_skipping, intake);
      intake.CommitWhenDue();
    }
    if (!text.empty() && !is_skipping) intake.Take(text);
  } catch (const ApiError&) {
    // A cut connection loses nothing of what had come.
    intake.Commit();
    throw;
  }
  intake.Commit();
  response.set_content(intake.Answer().dump(), "application/json");
}

}  // namespace freelsd
