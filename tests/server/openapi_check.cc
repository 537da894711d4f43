#include "tests/server/openapi_check.h"

#include <cctype>
#include <optional>
#include <set>
#include <sstream>

#include <doctest/doctest.h>

#include "api/api.h"

namespace freelsd {
namespace {

const nlohmann::json& Contract() {
  static const nlohmann::json kContract = nlohmann::json::parse(OpenApiJson());
  return kContract;
}

const nlohmann::json& Resolved(const nlohmann::json& node) {
  const auto reference = node.find("$ref");
  if (reference == node.end()) return node;
  const std::string pointer = reference->get<std::string>().substr(1);
  return Resolved(Contract().at(nlohmann::json::json_pointer(pointer)));
}

std::vector<std::string> SegmentsOf(const std::string& path) {
  std::vector<std::string> segments;
  std::istringstream stream(path.substr(0, path.find('?')));
  for (std::string segment; std::getline(stream, segment, '/');) segments.push_back(segment);
  return segments;
}

bool IsSegment(const std::string& pattern, const std::string& segment) {
  if (pattern.rfind('{', 0) != 0) return pattern == segment;
  const std::string suffix = pattern.substr(pattern.find('}') + 1);
  return segment.size() > suffix.size() && segment.ends_with(suffix);
}

// The path of the contract that a request's is one of, the most literal first.
std::optional<std::string> PatternOf(const std::string& path) {
  const std::vector<std::string> segments = SegmentsOf(path);
  std::optional<std::string> found;
  for (const auto& [pattern, item] : Contract()["paths"].items()) {
    const std::vector<std::string> parts = SegmentsOf(pattern);
    bool is_it = parts.size() == segments.size();
    for (size_t i = 0; is_it && i < parts.size(); ++i) is_it = IsSegment(parts[i], segments[i]);
    if (is_it && (!found || pattern.find('{') == std::string::npos)) found = pattern;
  }
  return found;
}

bool IsOfType(const nlohmann::json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  if (type == "integer") return value.is_number_integer();
  return value.is_number();
}

class Checker {
 public:
  std::vector<std::string> errors;

  // `known`: keys that another part of the same schema names.
  void Check(const nlohmann::json& value,
             const nlohmann::json& unresolved,
             const std::string& at,
             std::set<std::string> known = {}) {
    const nlohmann::json& schema = Resolved(unresolved);
    if (!schema.is_object()) return;
    CheckType(value, schema, at);
    CheckRange(value, schema, at);
    if (schema.contains("const") && value != schema["const"]) Add(at, "is not the constant");
    if (schema.contains("enum") && !Contains(schema["enum"], value)) {
      Add(at, "is none of the enum: " + value.dump());
    }
    known.merge(KeysOf(schema));
    for (const nlohmann::json& part : schema.value("allOf", nlohmann::json::array())) {
      Check(value, part, at, known);
    }
    CheckAlternatives(value, schema, at);
    if (value.is_object()) CheckObject(value, schema, at, known);
    if (value.is_array() && schema.contains("items")) {
      for (size_t i = 0; i < value.size(); ++i) {
        Check(value[i], schema["items"], at + "/" + std::to_string(i));
      }
    }
  }

 private:
  void Add(const std::string& at, const std::string& what) { errors.push_back(at + ": " + what); }

  static std::set<std::string> KeysOf(const nlohmann::json& unresolved) {
    const nlohmann::json& schema = Resolved(unresolved);
    std::set<std::string> keys;
    const nlohmann::json properties = schema.value("properties", nlohmann::json::object());
    for (const auto& [key, item] : properties.items()) keys.insert(key);
    for (const nlohmann::json& part : schema.value("allOf", nlohmann::json::array())) {
      keys.merge(KeysOf(part));
    }
    return keys;
  }

  static bool Contains(const nlohmann::json& list, const nlohmann::json& value) {
    for (const nlohmann::json& item : list) {
      if (item == value) return true;
    }
    return false;
  }

  void CheckType(const nlohmann::json& value, const nlohmann::json& schema, const std::string& at) {
    if (!schema.contains("type")) return;
    const nlohmann::json& type = schema["type"];
    bool is_one = type.is_string() && IsOfType(value, type);
    if (type.is_array()) {
      for (const nlohmann::json& each : type) is_one |= IsOfType(value, each);
    }
    if (!is_one) Add(at, "is not of type " + type.dump());
  }

  void CheckRange(const nlohmann::json& value,
                  const nlohmann::json& schema,
                  const std::string& at) {
    if (value.is_number()) {
      if (schema.contains("minimum") && value < schema["minimum"]) Add(at, "is below minimum");
      if (schema.contains("maximum") && value > schema["maximum"]) Add(at, "is above maximum");
    }
    if (value.is_array()) {
      if (schema.contains("minItems") && value.size() < schema["minItems"]) Add(at, "too few");
      if (schema.contains("maxItems") && value.size() > schema["maxItems"]) Add(at, "too many");
    }
  }

  void CheckAlternatives(const nlohmann::json& value,
                         const nlohmann::json& schema,
                         const std::string& at) {
    if (!schema.contains("oneOf")) return;
    std::vector<std::string> nearest{"has no alternative"};
    for (const nlohmann::json& alternative : schema["oneOf"]) {
      Checker checker;
      checker.Check(value, alternative, at);
      if (checker.errors.empty()) return;
      nearest = checker.errors;
    }
    Add(at, "fits none of oneOf, e.g. " + nearest[0]);
  }

  // A key that the contract does not name is a fault where it names any.
  void CheckObject(const nlohmann::json& value,
                   const nlohmann::json& schema,
                   const std::string& at,
                   const std::set<std::string>& known) {
    for (const nlohmann::json& key : schema.value("required", nlohmann::json::array())) {
      if (!value.contains(key)) Add(at, "has no " + key.get<std::string>());
    }
    const nlohmann::json properties = schema.value("properties", nlohmann::json::object());
    for (const auto& [key, item] : value.items()) {
      if (properties.contains(key)) {
        Check(item, properties[key], at + "/" + key);
      } else if (schema.contains("additionalProperties") &&
                 schema["additionalProperties"].is_object()) {
        Check(item, schema["additionalProperties"], at + "/" + key);
      } else if (!properties.empty() && !known.contains(key)) {
        Add(at + "/" + key, "is not in the contract");
      }
    }
  }
};

// The page and its files are for browsers, not part of the contract.
bool IsPage(const std::string& path) { return path.rfind("/v1", 0) != 0; }

std::string MediaTypeOf(const httplib::Response& response) {
  const std::string type = response.get_header_value("Content-Type");
  return type.substr(0, type.find(';'));
}

std::vector<std::string> BodyErrors(const nlohmann::json& documented,
                                    const httplib::Response& response) {
  const nlohmann::json content = documented.value("content", nlohmann::json::object());
  if (content.empty()) return {};
  const std::string type = MediaTypeOf(response);
  if (!content.contains(type)) return {"the media type \"" + type + "\" is not in the contract"};
  if (!content[type].contains("schema") || type.find("json") == std::string::npos) return {};
  const nlohmann::json body = nlohmann::json::parse(response.body, nullptr, false);
  if (body.is_discarded()) return {"the body is no JSON"};
  return SchemaErrors(body, content[type]["schema"]);
}

// A refusal of no operation: made for a path or a method that the contract does not name, or by the
// listener of emergencies, which has few of the paths.
bool IsOfNoOperation(const httplib::Response& response) {
  const nlohmann::json body = nlohmann::json::parse(response.body, nullptr, false);
  return body.is_object() && body.value("code", "") == "NotFound";
}

std::vector<std::string> ProblemErrors(const httplib::Response& response) {
  constexpr const char* kType = "application/problem+json";
  return BodyErrors(
      {{"content", {{kType, {{"schema", {{"$ref", "#/components/schemas/Problem"}}}}}}}}, response);
}

}  // namespace

void HoldAgainstContract(httplib::Client& client) {
  client.set_logger([](const httplib::Request& request, const httplib::Response& response) {
    for (const std::string& what : UndocumentedIn(request, response)) {
      FAIL_CHECK(request.method << " " << request.path << " " << response.status << ": " << what);
    }
  });
}

std::vector<std::string> SchemaErrors(const nlohmann::json& value, const nlohmann::json& schema) {
  Checker checker;
  checker.Check(value, schema, "");
  return checker.errors;
}

std::vector<std::string> UndocumentedIn(const httplib::Request& request,
                                        const httplib::Response& response) {
  const std::optional<std::string> pattern = PatternOf(request.path);
  std::string method = request.method;
  for (char& c : method) c = static_cast<char>(std::tolower(c));
  const bool is_head = method == "head";
  if (is_head) method = "get";
  const bool is_routed = pattern && Contract()["paths"][*pattern].contains(method);
  if (is_head && response.status < 500) return {};
  const bool is_refused = response.status >= 400;
  if (is_refused && (!is_routed || IsOfNoOperation(response))) return ProblemErrors(response);
  if (!is_routed && IsPage(request.path)) return {};
  if (!is_routed) return {request.method + " is not in the contract"};
  const nlohmann::json& responses = Contract()["paths"][*pattern][method]["responses"];
  const std::string status = std::to_string(response.status);
  if (response.status == 500) return {"the server failed: " + response.body};
  if (!responses.contains(status)) return {"the status " + status + " is not in the contract"};
  return BodyErrors(Resolved(responses[status]), response);
}

}  // namespace freelsd
