#include "api/capture_time.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

constexpr int64_t kHourUs = int64_t{3600} * 1000000;
constexpr int64_t kArrivedUs = 1793491200000000;  // 2026-11-01
constexpr int64_t kMaxUs = std::numeric_limits<int64_t>::max();

CaptureTime InBatch(const std::optional<int64_t>& timestamp_us,
                    TimeSource source = TimeSource::kGiven) {
  return CaptureTimeOf(timestamp_us, source, {kArrivedUs, false});
}

TEST_CASE("capture time: no date, before 2010 or after the arrival is unknown, but before it") {
  for (const std::optional<int64_t> unusable : {std::optional<int64_t>(),
                                                std::optional<int64_t>(0),
                                                std::optional<int64_t>(kEarliestCaptureUs - 1),
                                                std::optional<int64_t>(kArrivedUs + kHourUs),
                                                std::optional<int64_t>(kMaxUs),
                                                std::optional<int64_t>(-kMaxUs)}) {
    for (const TimeSource source : {TimeSource::kGiven, TimeSource::kCameraLocal}) {
      if (source == TimeSource::kCameraLocal && unusable == kArrivedUs + kHourUs) continue;
      if (source == TimeSource::kCameraLocal && unusable == kEarliestCaptureUs - 1) continue;
      const CaptureTime time = InBatch(unusable, source);
      CHECK_FALSE(time.IsDated());
      CHECK_FALSE(time.source);
      CHECK(time.latest_us == kArrivedUs);
      // Sent while it was taken.
      const CaptureTime live = CaptureTimeOf(unusable, source, {kArrivedUs, true});
      CHECK(live.IsExact());
      CHECK(live.earliest_us == kArrivedUs);
      CHECK(live.source == TimeSource::kArrival);
    }
  }
  CHECK(InBatch(kArrivedUs - 1).IsExact());
  // Clocks differ a little.
  CHECK(InBatch(kArrivedUs + 60000000).IsExact());
  // The server's clock was not set either.
  CHECK(CaptureTimeOf(std::nullopt, TimeSource::kGiven, {7, true}).latest_us > kArrivedUs);
  CHECK(CaptureTimeOf(kArrivedUs, TimeSource::kGiven, {7, false}).IsExact());
}

TEST_CASE("capture time: local time is uncertain by 14 hours, and never after the arrival") {
  const CaptureTime old = InBatch(kArrivedUs - 100 * kHourUs, TimeSource::kCameraLocal);
  CHECK(old.earliest_us == kArrivedUs - 114 * kHourUs);
  CHECK(old.latest_us == kArrivedUs - 86 * kHourUs);
  // Two hours ahead of UTC, an hour ago.
  const CaptureTime recent = InBatch(kArrivedUs + kHourUs, TimeSource::kCameraLocal);
  CHECK(recent.earliest_us == kArrivedUs - 13 * kHourUs);
  CHECK(recent.latest_us < kArrivedUs + kHourUs);
  CHECK(recent.source == TimeSource::kCameraLocal);
}

TEST_CASE("capture time: one of two is later, or their order is contested, or they are equal") {
  const CaptureTime early{10, 10}, late{20, 20}, around{5, 15}, undated{0, 15};
  CHECK(IsLater(late, early));
  CHECK_FALSE(IsLater(early, late));
  CHECK_FALSE(IsContested(early, late));
  CHECK_FALSE(IsLater(early, early));
  CHECK_FALSE(IsContested(early, early));
  CHECK(IsContested(early, around));
  CHECK(IsContested(around, around));
  CHECK(IsLater(late, around));
  // It arrived before the later one was taken.
  CHECK(IsContested(early, undated));
  CHECK(IsLater(late, undated));
  CHECK(IsContested(undated, undated));
  CHECK(IsContested(late, CaptureTime()));
}

TEST_CASE("capture time: of many photographs, the newest may be an undated one") {
  const CaptureTime newest = Newest(CaptureTime{10, 10}, CaptureTime{0, 15});
  CHECK(newest.earliest_us == 10);
  CHECK(newest.latest_us == 15);
  CHECK(Newest(CaptureTime{10, 10}, CaptureTime{12, 12}).IsExact());
}

}  // namespace
}  // namespace freelsd
