#include "engine/classification/log_levels.h"

#include <cmath>

namespace freelsd {
namespace {

constexpr float kLogOffset = 4.0f;

LogLevels MakeLogLevels() {
  LogLevels logs;
  for (size_t level = 0; level < logs.size(); ++level) {
    logs[level] = std::log(static_cast<float>(level) + kLogOffset);
  }
  return logs;
}

}  // namespace

const LogLevels& LogOfLevel() {
  static const LogLevels kLogs = MakeLogLevels();
  return kLogs;
}

}  // namespace freelsd
