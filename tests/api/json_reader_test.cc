#include "api/json_reader.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/errors.h"

namespace freelsd {
namespace {

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

}  // namespace
}  // namespace freelsd
