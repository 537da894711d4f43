// What the service counts of itself, for Prometheus.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace freelsd {

class Metrics {
 public:
  // Thread-safe. `route`: the pattern, never what a client sent.
  void CountRequest(const std::string& method,
                    const std::string& route,
                    int http_status,
                    double seconds);
  // Exposition format 0.0.4: requests by route and status, and their time.
  std::string Text() const;

 private:
  struct Sum {
    int64_t count = 0;
    double seconds = 0.0;
  };
  mutable std::mutex mutex_;
  // By labels as they are written.
  std::map<std::string, Sum> requests_;
};

}  // namespace freelsd
