#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/api.h"
#include "tests/api/errors.h"

namespace freelsd {
namespace {

TEST_CASE("error: a problem has all members of the contract, and its limit") {
  ApiError error("ImageTooLarge", "900 megapixels", {{"/image", "too large"}});
  error.limit = 64e6;
  error.observed = 9e8;
  const auto problem = nlohmann::json::parse(ProblemJson(error));
  CHECK(problem["status"] == 413);
  CHECK(problem["code"] == "ImageTooLarge");
  CHECK(problem["title"].is_string());
  CHECK(problem["type"].is_string());
  CHECK(problem["detail"] == "900 megapixels");
  CHECK(problem["errors"][0]["pointer"] == "/image");
  CHECK(problem["limit"] == 64e6);
  CHECK(problem["observed"] == 9e8);
  CHECK(problem["retryable"] == false);
}

TEST_CASE("error: what can be tried again says when") {
  CHECK(RetryAfterSeconds("QueueFull").has_value());
  CHECK(RetryAfterSeconds("ShuttingDown").has_value());
  CHECK_FALSE(RetryAfterSeconds("InvalidJson").has_value());
  CHECK(nlohmann::json::parse(ProblemJson(429, "QueueFull", "full"))["retryable"] == true);
}

TEST_CASE("error: an unknown code is the server's fault, and bytes that are no text do no harm") {
  CHECK(ApiError("Whatever", "").http_status() == 500);
  CHECK(nlohmann::json::parse(ProblemJson(ApiError("InvalidJson", "\xff\xfe"))).is_object());
}

TEST_CASE("openapi: the contract is JSON and knows the main routes") {
  const auto contract = nlohmann::json::parse(OpenApiJson());
  CHECK(contract["openapi"] == "3.1.0");
  for (const char* const path : {"/v1/flights",
                                 "/v1/flights/{flight}/frames/{frame}",
                                 "/v1/flights/{flight}/batch",
                                 "/v1/flights/{flight}/finish",
                                 "/v1/sites/{site}/approach",
                                 "/v1/sites/{site}/wind-rose",
                                 "/v1/emergency"}) {
    CAPTURE(std::string(path));
    CHECK(contract["paths"].contains(path));
  }
}

}  // namespace
}  // namespace freelsd
