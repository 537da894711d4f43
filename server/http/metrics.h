// Number and duration of requests, for Prometheus.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace freelsd {

// Thread-safe.
class Metrics {
 public:
  // `route` is a pattern from the route table, never text from a client, because the number of
  // labels must be bounded.
  void CountRequest(const std::string& method,
                    const std::string& route,
                    int http_status,
                    double seconds);
  // Prometheus exposition format 0.0.4: number and total seconds of requests, by method, route and
  // status.
  std::string Text() const;

 private:
  struct Sum {
    int64_t count = 0;
    double seconds = 0.0;
  };
  // Guards requests_.
  mutable std::mutex mutex_;
  // By labels in exposition format.
  std::map<std::string, Sum> requests_;
};

}  // namespace freelsd
