// How many live uploads a server takes at the same time.
#pragma once

#include <algorithm>

#include "api/api.h"
#include "server/config.h"

namespace freelsd {

// Each of them holds a thread of its own, so the setting of threads bounds them too.
inline int MaxNumStreams(const Config& config) {
  constexpr int kThreadsOfStream = 4;
  return std::max(kLimits.concurrency.max_num_streams, config.num_http_threads / kThreadsOfStream);
}

}  // namespace freelsd
