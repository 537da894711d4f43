// When a photograph was taken, from its tags. Private to images/.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "api/capture_time.h"
#include "api/import/images/tag_source.h"

namespace freelsd {

struct TaggedTime {
  std::optional<int64_t> timestamp_us;
  TimeSource source = TimeSource::kGiven;
  std::vector<std::string> warnings;
};
// The receiver's time is preferred, then the camera's with its offset from UTC, then the camera's
// alone.
TaggedTime TimeFromTags(const TagSource& tags);

}  // namespace freelsd
