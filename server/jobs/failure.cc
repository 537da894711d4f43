#include "server/jobs/failure.h"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "server/jobs/job_json.h"

namespace freelsd {

std::string Sentence(const std::exception& error) {
  if (const auto* const opencv = dynamic_cast<const cv::Exception*>(&error)) {
    // OpenCV's what() names source files.
    return "image processing failed: " + std::string(opencv->err);
  }
  return error.what();
}

void FailJob(Service& service, JobRow job, const std::string& why) {
  nlohmann::json detail = nlohmann::json::parse(job.detail_json);
  detail["message"] = why;
  job.detail_json = detail.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  job.state = JobState::kFailed;
  UpdateJob(service, job);
}

}  // namespace freelsd
