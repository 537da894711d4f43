#include "server/intake/warnings.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace freelsd {
namespace {

// Most sentences of one source; bounds the stored row.
constexpr size_t kMaxNumSentences = 100;

nlohmann::json Parse(const std::string& warnings_json) {
  nlohmann::json object = nlohmann::json::parse(warnings_json);
  return object.is_object() ? object : nlohmann::json::object();
}

std::string Dump(const nlohmann::json& object) {
  return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string ReplaceWarnings(const std::string& warnings_json,
                            const std::string& source,
                            const std::vector<std::string>& sentences) {
  nlohmann::json object = Parse(warnings_json);
  object.erase(source);
  return AddWarnings(Dump(object), source, sentences);
}

std::string AddWarnings(const std::string& warnings_json,
                        const std::string& source,
                        const std::vector<std::string>& sentences) {
  nlohmann::json object = Parse(warnings_json);
  nlohmann::json& list = object[source];
  if (!list.is_array()) list = nlohmann::json::array();
  for (const std::string& sentence : sentences) {
    const bool is_known = std::find(list.begin(), list.end(), sentence) != list.end();
    if (!is_known && list.size() < kMaxNumSentences) list.push_back(sentence);
  }
  return Dump(object);
}

std::vector<std::string> AllWarnings(const std::string& warnings_json) {
  std::vector<std::string> sentences;
  for (const nlohmann::json& list : Parse(warnings_json)) {
    for (const nlohmann::json& sentence : list) sentences.push_back(sentence);
  }
  return sentences;
}

}  // namespace freelsd
