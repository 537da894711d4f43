#include "api/import/yaml.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "api/import/tag_source.h"

namespace freelsd {
namespace {

constexpr size_t kMaxBytes = 64u << 10;
constexpr int kMaxDepth = 16;

// One line, or several that a bracket holds together.
struct YamlLine {
  int number = 0;
  size_t indent = 0;
  std::string content;
};

[[noreturn]] void Refuse(int line, const std::string& what) {
  throw std::invalid_argument("line " + std::to_string(line) + ": " + what);
}

std::string Trimmed(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string WithoutComment(const std::string& line) {
  char quote = '\0';
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#' && (i == 0 || line[i - 1] == ' ')) {
      return line.substr(0, i);
    }
  }
  return line;
}

int BracketBalance(const std::string& text) {
  int balance = 0;
  for (const char c : text) balance += c == '[' ? 1 : c == ']' ? -1 : 0;
  return balance;
}

std::vector<YamlLine> SplitLines(std::string_view text) {
  std::vector<YamlLine> lines;
  int number = 0, open_brackets = 0;
  while (!text.empty()) {
    ++number;
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string line = WithoutComment(std::string(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string content = Trimmed(line);
    if (content.empty() || content[0] == '%' || content == "---" || content == "...") continue;
    if (open_brackets > 0) {
      lines.back().content += " " + content;
    } else {
      lines.push_back({number, line.find_first_not_of(" \t"), content});
    }
    open_brackets += BracketBalance(content);
  }
  return lines;
}

class YamlReader {
 public:
  explicit YamlReader(std::vector<YamlLine> lines) : lines_(std::move(lines)) {}

  nlohmann::json Read() {
    if (lines_.empty()) return nullptr;
    nlohmann::json value = ReadBlock(lines_[0].indent, 0);
    if (next_ < lines_.size()) Refuse(lines_[next_].number, "the indentation is not understood");
    return value;
  }

 private:
  static bool IsItem(const std::string& content) {
    return content == "-" || content.rfind("- ", 0) == 0;
  }

  nlohmann::json ReadBlock(size_t indent, int depth) {
    if (depth > kMaxDepth) Refuse(lines_[next_].number, "too deep");
    return IsItem(lines_[next_].content) ? ReadList(indent, depth) : ReadMap(indent, depth);
  }

  nlohmann::json ReadList(size_t indent, int depth) {
    nlohmann::json list = nlohmann::json::array();
    while (next_ < lines_.size() && lines_[next_].indent == indent &&
           IsItem(lines_[next_].content)) {
      const YamlLine line = lines_[next_++];
      list.push_back(Value(Trimmed(line.content.substr(1)), line, depth));
    }
    return list;
  }

  nlohmann::json ReadMap(size_t indent, int depth) {
    nlohmann::json map = nlohmann::json::object();
    while (next_ < lines_.size() && lines_[next_].indent == indent) {
      const YamlLine line = lines_[next_++];
      const size_t colon = line.content.find(':');
      if (colon == std::string::npos) Refuse(line.number, "is no key with a value");
      const std::string key = Trimmed(line.content.substr(0, colon));
      if (map.contains(key)) Refuse(line.number, "the key \"" + key + "\" comes twice");
      std::string rest = Trimmed(line.content.substr(colon + 1));
      if (rest.rfind("!!", 0) == 0)
        rest = Trimmed(rest.substr(std::min(rest.find(' '), rest.size())));
      map[key] = rest.empty() ? ReadNested(indent, depth) : Value(rest, line, depth);
    }
    return map;
  }

  // What stands below a key; a list may stand as far left as its key.
  nlohmann::json ReadNested(size_t indent, int depth) {
    if (next_ >= lines_.size()) return nullptr;
    const YamlLine& line = lines_[next_];
    const bool is_below = line.indent > indent || (line.indent == indent && IsItem(line.content));
    return is_below ? ReadBlock(line.indent, depth + 1) : nlohmann::json(nullptr);
  }

  static nlohmann::json Value(const std::string& text, const YamlLine& line, int depth) {
    if (depth > kMaxDepth) Refuse(line.number, "too deep");
    if (text.empty()) return nullptr;
    if (text[0] == '&' || text[0] == '*') Refuse(line.number, "anchors and aliases are not read");
    if (text[0] == '[') return FlowList(text, line, depth);
    const bool is_quoted = text.size() > 1 && (text[0] == '"' || text[0] == '\'');
    if (is_quoted) return text.substr(1, text.find(text[0], 1) - 1);
    if (const auto number = NumberFromText(text)) return *number;
    return text;
  }

  static nlohmann::json FlowList(const std::string& text, const YamlLine& line, int depth) {
    if (text.back() != ']') Refuse(line.number, "a bracket is never closed");
    nlohmann::json list = nlohmann::json::array();
    std::string item;
    int open_brackets = 0;
    for (size_t i = 1; i < text.size(); ++i) {
      const bool is_end = open_brackets == 0 && (text[i] == ',' || i + 1 == text.size());
      if (is_end) {
        if (!Trimmed(item).empty()) list.push_back(Value(Trimmed(item), line, depth + 1));
        item.clear();
        continue;
      }
      open_brackets += text[i] == '[' ? 1 : text[i] == ']' ? -1 : 0;
      item += text[i];
    }
    return list;
  }

  std::vector<YamlLine> lines_;
  size_t next_ = 0;
};

}  // namespace

nlohmann::json ParseYaml(std::string_view text) {
  if (text.size() > kMaxBytes) throw std::invalid_argument("more than 64 KiB");
  return YamlReader(SplitLines(text)).Read();
}

}  // namespace freelsd
