#include "api/capture_time.h"

#include <algorithm>
#include <utility>

namespace freelsd {
namespace {

constexpr std::pair<TimeSource, std::string_view> kSources[] = {
    {TimeSource::kGiven, "given"},
    {TimeSource::kGps, "gps"},
    {TimeSource::kCamera, "camera"},
    {TimeSource::kCameraLocal, "camera_local"},
    {TimeSource::kArrival, "arrival"}};

// By so much a clock that is right may be ahead of the server's.
constexpr int64_t kMaxAheadUs = int64_t{300} * 1000000;

// Nothing if the time is not plausible.
std::optional<CaptureTime> Plausible(int64_t timestamp_us, TimeSource source, int64_t until_us) {
  const int64_t spread_us = source == TimeSource::kCameraLocal ? kMaxUtcOffsetUs : 0;
  if (timestamp_us < kEarliestCaptureUs - spread_us) return std::nullopt;
  if (timestamp_us - spread_us > until_us) return std::nullopt;
  const int64_t earliest_us = std::max(timestamp_us - spread_us, kEarliestCaptureUs);
  return CaptureTime{earliest_us, std::min(timestamp_us, until_us - spread_us) + spread_us, source};
}

}  // namespace

std::string_view NameOf(TimeSource source) {
  return std::find_if(std::begin(kSources),
                      std::end(kSources),
                      [source](const auto& each) { return each.first == source; })
      ->second;
}

std::optional<TimeSource> TimeSourceOf(std::string_view name) {
  for (const auto& [source, known] : kSources) {
    if (known == name) return source;
  }
  return std::nullopt;
}

CaptureTime CaptureTimeOf(const std::optional<int64_t>& timestamp_us,
                          TimeSource source,
                          const Arrival& arrival) {
  const bool is_arrival_known = arrival.arrived_at_us >= kEarliestCaptureUs;
  const int64_t arrived_at_us =
      is_arrival_known ? arrival.arrived_at_us : std::numeric_limits<int64_t>::max() - kMaxAheadUs;
  if (timestamp_us) {
    if (const auto time = Plausible(*timestamp_us, source, arrived_at_us + kMaxAheadUs)) {
      return *time;
    }
  }
  if (arrival.is_live && is_arrival_known) {
    return {arrived_at_us, arrived_at_us, TimeSource::kArrival};
  }
  return {0, arrived_at_us, std::nullopt};
}

CaptureTime Newest(const CaptureTime& a, const CaptureTime& b) {
  return {std::max(a.earliest_us, b.earliest_us),
          std::max(a.latest_us, b.latest_us),
          a.latest_us < b.latest_us ? b.source : a.source};
}

bool IsLater(const CaptureTime& a, const CaptureTime& b) { return a.earliest_us > b.latest_us; }

bool IsContested(const CaptureTime& a, const CaptureTime& b) {
  return !IsLater(a, b) && !IsLater(b, a) && !(a.IsExact() && b.IsExact());
}

}  // namespace freelsd
