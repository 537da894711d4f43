#include "api/export/text.h"

#include <cstdio>
#include <string_view>

namespace freelsd {

std::string FixedText(double number, int num_decimals) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", num_decimals, number);
  return text;
}

std::string OneLine(const std::string& text) {
  std::string line = text;
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return line;
}

std::string CellText(const std::string& text) {
  constexpr std::string_view kFormulaStarts = "=+-@\t\r";
  const bool is_formula = !text.empty() && kFormulaStarts.find(text[0]) != std::string_view::npos;
  return is_formula ? "'" + text : text;
}

std::string EscapeXml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&') {
      escaped += "&amp;";
    } else if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else if (c == '\'') {
      escaped += "&#39;";
    } else if (static_cast<unsigned char>(c) >= ' ' || c == '\n' || c == '\t') {
      escaped += c;
    }
  }
  return escaped;
}

}  // namespace freelsd
