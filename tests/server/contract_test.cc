// The contract and the server say the same. Beside this, every answer that any test here gets is
// held against it (test_server.cc).
#include <cctype>

#include <doctest/doctest.h>

#include "api/api.h"
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

TEST_CASE("contract: each operation names the statuses of its refusals, none says \"default\"") {
  FreshServer fresh;
  const nlohmann::json contract = GetJson(fresh.client, "/openapi.json");
  for (const auto& entry : contract["paths"].items()) {
    const std::string& path = entry.key();
    const nlohmann::json& item = entry.value();
    for (const char* const method : {"get", "put", "post", "delete"}) {
      if (!item.contains(method)) continue;
      INFO(method << " " << path);
      const nlohmann::json& responses = item[method]["responses"];
      CHECK_FALSE(responses.contains("default"));
      // Of every request: a query that is not known, another host, a head that is too large.
      for (const char* const status : {"400", "403", "414", "431", "500"}) {
        CHECK(responses.contains(status));
      }
      CHECK(responses.contains("401") == (path != "/healthz"));
      const bool is_of_something = path.find('{') != std::string::npos;
      CHECK((responses.contains("404") || !is_of_something));
    }
  }
}

TEST_CASE("contract: an answer whose status it does not name for the operation is a fault") {
  httplib::Request request;
  request.method = "GET";
  request.path = "/v1/flights";
  httplib::Response response;
  response.status = 409;
  response.set_header("Content-Type", "application/problem+json");
  response.body = ProblemJson(ApiError("Conflict", "for a test"));
  REQUIRE(UndocumentedIn(request, response).size() == 1);
  CHECK(UndocumentedIn(request, response)[0] == "the status 409 is not in the contract");
  request.path = "/v1/sites/x/approach";
  CHECK(UndocumentedIn(request, response).empty());
}

TEST_CASE("contract: every path in it is served, with the methods that it names") {
  FreshServer fresh;
  const nlohmann::json contract = GetJson(fresh.client, "/openapi.json");
  for (const auto& entry : contract["paths"].items()) {
    const std::string& path = entry.key();
    const nlohmann::json& item = entry.value();
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
