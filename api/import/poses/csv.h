// Comma-separated values as in RFC 4180 and as common programs write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct CsvLine {
  // Line of the first character, from 1.
  int number = 0;
  std::vector<std::string> cells;
};

// Reads quotes, doubled quotes and CRLF; skips blank lines. The separator is a comma if the first
// line contains one, else a semicolon, else a tab. Throws std::invalid_argument if a quote never
// closes. `first_line_number` is the file's line at which the text starts.
std::vector<CsvLine> ParseCsv(std::string_view text, int first_line_number = 1);

}  // namespace freelsd
