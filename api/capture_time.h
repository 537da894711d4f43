// When a photograph was taken, as far as it is known, and the one comparison of such times.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

// What a frame's time comes from.
enum class TimeSource {
  kGiven,        // the client: meta, a pose file, X-Timestamp-Us
  kGps,          // the receiver
  kCamera,       // the camera's clock, and its offset from UTC
  kCameraLocal,  // the camera's clock, with an unknown offset: read as UTC
  kArrival       // the server's clock
};
// As in openapi.yaml: "given", "gps", "camera", "camera_local" or "arrival".
std::string_view NameOf(TimeSource source);
std::optional<TimeSource> TimeSourceOf(std::string_view name);

// Earlier times come from a clock that was never set. 2010, microseconds since 1970.
constexpr int64_t kEarliestCaptureUs = 1262304000000000;
// Largest difference of a local time from UTC.
constexpr int64_t kMaxUtcOffsetUs = int64_t{14} * 3600 * 1000000;

// The true time lies within both bounds, microseconds since 1970.
struct CaptureTime {
  // 0: nothing tells when. Ground that was last seen then counts as older than any dated one.
  int64_t earliest_us = 0;
  int64_t latest_us = std::numeric_limits<int64_t>::max();
  std::optional<TimeSource> source = std::nullopt;

  bool IsDated() const { return earliest_us > 0; }
  bool IsExact() const { return earliest_us == latest_us; }
};

// By frame.
using CaptureTimes = std::map<std::string, CaptureTime>;

// When and how a photograph reached the server.
struct Arrival {
  int64_t arrived_at_us = 0;
  // Sent while it was taken. Photographs of a batch may be of any age.
  bool is_live = false;
};
// `timestamp_us` counts if it lies between 2010 and the arrival. Else a live photograph was taken
// when it arrived, and another one at an unknown time before it arrived.
CaptureTime CaptureTimeOf(const std::optional<int64_t>& timestamp_us,
                          TimeSource source,
                          const Arrival& arrival);
// Of the later of two photographs.
CaptureTime Newest(const CaptureTime& a, const CaptureTime& b);

// `a` is surely later than `b`.
bool IsLater(const CaptureTime& a, const CaptureTime& b);
// Which of the two is later is not known. Two equal times are not contested: neither is later.
bool IsContested(const CaptureTime& a, const CaptureTime& b);

}  // namespace freelsd
