#include "api/import/poses/yaml.h"

#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "api/import/number_text.h"
#include "api/limits.h"

namespace freelsd {
namespace {

[[noreturn]] void Refuse(const YAML::Mark& mark, const std::string& what) {
  // yaml-cpp counts from 0.
  throw std::invalid_argument("line " + std::to_string(mark.line + 1) + ": " + what);
}

// Builds JSON from the parser's events. It refuses each level beyond the limit, which also ends
// the parser's own recursion. It refuses aliases because they could make a small text large.
// NOLINTNEXTLINE(bugprone-exception-escape): an empty json throws nothing.
class JsonBuilder : public YAML::EventHandler {
 public:
  const nlohmann::json& root() const { return root_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    RefuseAnchor(mark, anchor);
    Add(mark, nullptr);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    RefuseAnchor(mark, anchor);
  }
  void OnScalar(const YAML::Mark& mark,
                const std::string& tag,
                YAML::anchor_t anchor,
                const std::string& value) override {
    RefuseAnchor(mark, anchor);
    const bool is_key = !open_.empty() && open_.back().value.is_object() && !open_.back().key;
    if (is_key) return SetKey(mark, value);
    // "!" marks quoted text.
    Add(mark, tag == "!" ? nlohmann::json(value) : PlainValue(value));
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string&,
                       YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(mark, anchor, nlohmann::json::array());
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapStart(const YAML::Mark& mark,
                  const std::string&,
                  YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Open(mark, anchor, nlohmann::json::object());
  }
  void OnMapEnd() override { Close(); }

 private:
  struct OpenValue {
    YAML::Mark mark;
    nlohmann::json value;
    // Key of the next value in a map.
    std::optional<std::string> key;
  };

  static void RefuseAnchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != YAML::NullAnchor) Refuse(mark, "anchors and aliases are not read");
  }

  static nlohmann::json PlainValue(const std::string& text) {
    if (text.empty() || text == "~" || text == "null") return nullptr;
    if (const auto number = NumberFromText(text)) return *number;
    return text;
  }

  void SetKey(const YAML::Mark& mark, const std::string& key) {
    if (open_.back().value.contains(key)) Refuse(mark, "the key \"" + key + "\" comes twice");
    open_.back().key = key;
  }

  void Open(const YAML::Mark& mark, YAML::anchor_t anchor, nlohmann::json empty) {
    RefuseAnchor(mark, anchor);
    if (open_.size() >= static_cast<size_t>(kLimits.poses.max_yaml_depth)) {
      Refuse(mark, "nested deeper than " + std::to_string(kLimits.poses.max_yaml_depth));
    }
    open_.push_back({mark, std::move(empty), std::nullopt});
  }

  void Close() {
    OpenValue closed = std::move(open_.back());
    open_.pop_back();
    Add(closed.mark, std::move(closed.value));
  }

  void Add(const YAML::Mark& mark, nlohmann::json value) {
    if (open_.empty()) {
      root_ = std::move(value);
    } else if (open_.back().value.is_array()) {
      open_.back().value.push_back(std::move(value));
    } else if (open_.back().key) {
      open_.back().value[*std::exchange(open_.back().key, std::nullopt)] = std::move(value);
    } else {
      Refuse(mark, "a key must be a word");
    }
  }

  nlohmann::json root_;
  std::vector<OpenValue> open_;
};

}  // namespace

nlohmann::json ParseYaml(std::string_view text) {
  if (text.size() > kLimits.poses.max_yaml_bytes) {
    throw std::invalid_argument("more than " + std::to_string(kLimits.poses.max_yaml_bytes >> 10) +
                                " KiB");
  }
  std::istringstream stream{std::string(text)};
  JsonBuilder builder;
  try {
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
  } catch (const YAML::Exception& error) {
    Refuse(error.mark, error.msg);
  }
  const nlohmann::json& root = builder.root();
  if (!root.is_null() && !root.is_structured())
    throw std::invalid_argument("line 1: no key with a value");
  return root;
}

}  // namespace freelsd
