#include "server/http/stamps.h"

#include <chrono>
#include <ctime>
#include <random>

namespace freelsd {

int64_t NowUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string Rfc3339(int64_t timestamp_us) {
  const std::time_t seconds = timestamp_us / 1000000;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string NewId(const std::string& prefix) {
  constexpr char kDigits[] = "0123456789abcdef";
  constexpr int kNumDigits = 12;
  std::random_device entropy;
  std::string id = prefix + "-";
  for (int i = 0; i < kNumDigits; ++i) id += kDigits[entropy() % 16];
  return id;
}

}  // namespace freelsd
