#include "api/import/poses/csv.h"

#include <stdexcept>
#include <utility>

namespace freelsd {
namespace {

char SeparatorOf(std::string_view text) {
  const std::string_view header = text.substr(0, text.find('\n'));
  for (const char separator : {',', ';', '\t'}) {
    if (header.find(separator) != std::string_view::npos) return separator;
  }
  return ',';
}

// State machine that reads one character at a time.
class CsvReader {
 public:
  CsvReader(char separator, int first_line_number)
      : separator_(separator), num_newlines_(first_line_number - 1), line_{first_line_number, {}} {}

  void Take(char c, char next) {
    if (c == '\n') ++num_newlines_;
    if (is_quoted_) {
      TakeQuoted(c, next);
    } else if (c == '"' && cell_.empty()) {
      is_quoted_ = true;
    } else if (c == separator_) {
      EndCell();
    } else if (c == '\n') {
      EndLine();
    } else if (c != '\r' || next != '\n') {
      cell_ += c;
    }
  }

  std::vector<CsvLine> Finish() {
    if (is_quoted_) throw std::invalid_argument("a quote is never closed");
    ++num_newlines_;
    EndLine();
    return std::move(lines_);
  }

 private:
  void TakeQuoted(char c, char next) {
    if (c == '"' && is_second_quote_) {
      is_second_quote_ = false;
    } else if (c == '"' && next == '"') {
      is_second_quote_ = true;
      cell_ += c;
    } else if (c == '"') {
      is_quoted_ = false;
    } else {
      cell_ += c;
    }
  }

  void EndCell() { line_.cells.push_back(std::exchange(cell_, {})); }

  void EndLine() {
    EndCell();
    const bool is_blank = line_.cells.size() == 1 && line_.cells[0].empty();
    if (!is_blank) lines_.push_back(line_);
    line_ = {num_newlines_ + 1, {}};
  }

  char separator_;
  bool is_quoted_ = false;
  bool is_second_quote_ = false;
  int num_newlines_;
  std::string cell_;
  CsvLine line_;
  std::vector<CsvLine> lines_;
};

}  // namespace

std::vector<CsvLine> ParseCsv(std::string_view text, int first_line_number) {
  CsvReader reader(SeparatorOf(text), first_line_number);
  for (size_t i = 0; i < text.size(); ++i) {
    reader.Take(text[i], i + 1 < text.size() ? text[i + 1] : '\0');
  }
  return reader.Finish();
}

}  // namespace freelsd
