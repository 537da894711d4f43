#include "api/json_reader.h"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/api/errors.h"

namespace freelsd {
namespace {

TEST_CASE("json: characters that hide or turn the text around them are control characters") {
  for (const char* const bad : {"a\tb",
                                "a\x7F",
                                "\xC2\x85",       // next line
                                "\xD8\x9C",       // Arabic letter mark
                                "x\xE2\x80\x8F",  // right-to-left mark
                                "\xE2\x80\xA8",   // line separator
                                "gpj.\xE2\x80\xAE"
                                "evil",
                                "\xE2\x81\xA6"}) {
    CAPTURE(bad);
    CHECK(HasControlCharacter(bad));
  }
  for (const char* const good : {"",
                                 "Möhlin–Basel",
                                 "\xE2\x80\x93",                      // dash
                                 "\xC2\xA0",                          // no-break space
                                 "\xD9\x85\xD8\xB7\xD8\xA7\xD8\xB1",  // Arabic
                                 "\xF0\x9F\x91\xA8\xE2\x80\x8D\xF0\x9F\x8C\xBE"}) {
    CAPTURE(good);
    CHECK_FALSE(HasControlCharacter(good));
  }
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

}  // namespace
}  // namespace freelsd
