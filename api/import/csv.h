// Comma-separated values as RFC 4180 and the world write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct CsvLine {
  // Of its first character in the text, from 1.
  int number = 0;
  std::vector<std::string> cells;
};

// Quotes, doubled quotes, CRLF; blank lines are passed over. The separator is the first of comma,
// semicolon and tab that the first line has. Throws std::invalid_argument on a quote that never
// closes. `first_line_number`: of the text in its file.
std::vector<CsvLine> ParseCsv(std::string_view text, int first_line_number = 1);

}  // namespace freelsd
