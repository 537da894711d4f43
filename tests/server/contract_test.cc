// The contract and the server say the same. Beside this, every answer that any test here gets is
// held against it (test_server.cc).
#include <cctype>

#include <doctest/doctest.h>

#include "tests/server/openapi_check.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

std::string Filled(std::string path) {
  for (size_t open; (open = path.find('{')) != std::string::npos;) {
    path.replace(open, path.find('}') - open + 1, "x");
  }
  return path;
}

TEST_CASE("contract: the check itself sees types, ranges, missing and unknown keys") {
  const nlohmann::json schema = nlohmann::json::parse(R"({"type": "object", "required": ["a"],
      "properties": {"a": {"type": ["number", "null"], "minimum": 1},
                     "b": {"oneOf": [{"type": "null"}, {"$ref": "#/components/schemas/Wind"}]}}})");
  const auto is_valid = [&schema](const char* text) {
    return SchemaErrors(nlohmann::json::parse(text), schema).empty();
  };
  CHECK(is_valid(R"({"a": 1.5})"));
  CHECK(is_valid(R"({"a": null, "b": {"east_mps": 1, "north_mps": 2}})"));
  CHECK_FALSE(is_valid(R"({"a": 0.5})"));
  CHECK_FALSE(is_valid(R"({"a": "1"})"));
  CHECK_FALSE(is_valid(R"({})"));
  CHECK_FALSE(is_valid(R"({"a": 1, "c": 1})"));
  CHECK_FALSE(is_valid(R"({"a": 1, "b": {"east_mps": "1"}})"));
  CHECK_FALSE(is_valid(R"([])"));
}

TEST_CASE("contract: every path in it is served, with the methods that it names") {
  FreshServer fresh;
  const nlohmann::json contract = GetJson(fresh.client, "/openapi.json");
  for (const auto& [path, item] : contract["paths"].items()) {
    const auto result = fresh.client.Options(Filled(path));
    INFO(path);
    REQUIRE(result);
    // OPTIONS is refused, with what is allowed; a path that is not served has no such header.
    const std::string allowed = result->get_header_value("Allow");
    for (const char* const method : {"get", "put", "post", "delete"}) {
      std::string name = method;
      for (char& c : name) c = static_cast<char>(std::toupper(c));
      INFO(name);
      CHECK((allowed.find(name) != std::string::npos) == item.contains(method));
    }
  }
}

}  // namespace
}  // namespace freelsd
