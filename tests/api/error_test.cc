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

TEST_CASE("json: strict") {
  const auto error_of = [](const std::string& text) {
    return ErrorOf([&text] { ParseJson(text); });
  };
  CHECK(error_of(R"({"a": [1, 2.5, "x", null, true]})") == "nothing");
  for (const char* const bad : {"",
                                "{",
                                "{} x",
                                R"({"a": NaN})",
                                R"({"a": Infinity})",
                                R"({"a": 1e999})",
                                R"({"a": -1e999})",
                                R"({"a": 1, "a": 2})",
                                R"([{"b": {"a": 1, "a": 2}}])",
                                R"("\ud800")",
                                "\"\xff\"",
                                "[1,]"}) {
    CAPTURE(std::string(bad));
    CHECK(error_of(bad) == "400 InvalidJson");
  }
  CHECK(error_of(R"([{"a": 1}, {"a": 2}])") == "nothing");
}

TEST_CASE("json: nested 32 deep is read, 33 is refused, and 100000 does not crash") {
  const auto nested = [](size_t depth) {
    return std::string(depth, '[') + std::string(depth, ']');
  };
  CHECK_NOTHROW(ParseJson(nested(32)));
  CHECK(ErrorOf([&] { ParseJson(nested(33)); }) == "400 InvalidJson");
  CHECK(ErrorOf([&] { ParseJson(nested(100000)); }) == "400 InvalidJson");
  CHECK(ErrorOf([&] { ParseJson(std::string(100000, '[')); }) == "400 InvalidJson");
}

TEST_CASE("json: over its limit it is 413 with limit and observed") {
  try {
    ParseJson("[1, 2, 3]", 4);
    FAIL("must throw");
  } catch (const ApiError& error) {
    CHECK(error.http_status() == 413);
    CHECK(error.limit == 4.0);
    CHECK(error.observed == 9.0);
  }
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
