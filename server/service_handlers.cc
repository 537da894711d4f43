#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/handlers.h"

namespace freelsd {

void GetHealth(Service&, const Call&, httplib::Response& response) {
  response.set_content(R"({"status":"ok"})", "application/json");
}

void GetReadiness(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json reasons = nlohmann::json::array();
  if (service.is_stopping) reasons.push_back("the server is stopping");
  if (const auto reason = service.storage.WhyNotWritable())
    reasons.push_back("storage: " + *reason);
  const bool is_ready = reasons.empty();
  if (is_ready) {
    response.set_content(R"({"ready":true,"reasons":[]})", "application/json");
    return;
  }
  nlohmann::json problem = nlohmann::json::parse(
      ProblemJson(ApiError("Unavailable", "the server cannot accept work now")));
  problem["ready"] = false;
  problem["reasons"] = reasons;
  response.status = 503;
  response.set_content(problem.dump(), "application/problem+json");
  response.set_header("Retry-After", std::to_string(RetryAfterSeconds("Unavailable").value_or(1)));
}

void GetInfo(Service& service, const Call&, httplib::Response& response) {
  nlohmann::json info = OptionsJson();
  info["name"] = "freelsd";
  info["version"] = FREELSD_VERSION;
  info["limits"] = {{"max_image_megapixels", service.image_limits.max_megapixels},
                    {"max_image_side_px", service.image_limits.max_side_px},
                    {"max_image_bytes", service.image_limits.max_bytes},
                    {"max_batch_bytes", service.config.max_batch_bytes},
                    {"max_num_queued_frames", service.config.max_num_queued_frames},
                    {"max_json_bytes", 1 << 20}};
  response.set_content(info.dump(), "application/json");
}

void GetOpenApi(Service&, const Call&, httplib::Response& response) {
  response.set_content(std::string(OpenApiJson()), "application/json");
}

}  // namespace freelsd
