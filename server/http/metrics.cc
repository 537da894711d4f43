#include "server/http/metrics.h"

#include <sstream>

namespace freelsd {

void Metrics::CountRequest(const std::string& method,
                           const std::string& route,
                           int http_status,
                           double seconds) {
  const std::string labels = "method=\"" + method + "\",route=\"" + route + "\",status=\"" +
                             std::to_string(http_status) + "\"";
  const std::lock_guard lock(mutex_);
  Sum& sum = requests_[labels];
  ++sum.count;
  sum.seconds += seconds;
}

std::string Metrics::Text() const {
  std::ostringstream text;
  const std::lock_guard lock(mutex_);
  text << "# HELP freelsd_request_seconds Time from a request's head to its answer.\n"
          "# TYPE freelsd_request_seconds summary\n";
  for (const auto& [labels, sum] : requests_) {
    text << "freelsd_request_seconds_count{" << labels << "} " << sum.count << "\n"
         << "freelsd_request_seconds_sum{" << labels << "} " << sum.seconds << "\n";
  }
  return text.str();
}

}  // namespace freelsd
