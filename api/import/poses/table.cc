#include "api/import/poses/table.h"

#include <algorithm>
#include <array>

#include "api/import/number_text.h"
#include "api/import/poses/pose_columns.h"
#include "api/import/poses/side_files.h"

namespace freelsd {
namespace {

// A line with this many known names is a header.
constexpr size_t kMinHeaderColumns = 2;
// Lines among which a header is searched.
constexpr size_t kMaxPreambleLines = 20;
constexpr std::array<char, 4> kSeparators{',', ';', '\t', ' '};

bool IsSpace(char c) { return c == ' ' || c == '\t'; }

// The quoted text that begins at `at`; `at` is behind it then. Empty, and `at` as it was, if there
// is none, or if it does not end.
std::string TakeQuoted(std::string_view line, size_t& at) {
  std::string text;
  const bool is_quoted = at < line.size() && line[at] == '"';
  if (!is_quoted || line.find('"', at + 1) == std::string_view::npos) return text;
  for (++at; at < line.size(); ++at) {
    if (line[at] == '"' && (++at == line.size() || line[at] != '"')) break;
    text += line[at];
  }
  return text;
}

// One line. Quotes, and doubled quotes in them, as in RFC 4180.
std::vector<std::string> CellsOf(std::string_view line, char separator) {
  const auto separates = [separator](char c) {
    return separator == ' ' ? IsSpace(c) : c == separator;
  };
  std::vector<std::string> cells;
  size_t at = 0;
  while (true) {
    while (at < line.size() && IsSpace(line[at]) && (separator == ' ' || !separates(line[at])))
      ++at;
    if (separator == ' ' && at == line.size()) return cells;
    std::string cell = TakeQuoted(line, at);
    while (at < line.size() && !separates(line[at])) cell += line[at++];
    cells.emplace_back(Trimmed(cell));
    if (at == line.size()) return cells;
    ++at;
  }
}

bool IsNumberCell(const std::string& cell) {
  return !cell.empty() && cell.find_first_not_of("0123456789.,+-eE") == std::string::npos &&
         cell.find_first_of("0123456789") != std::string::npos;
}

// An image and two numbers. Without an extension the image comes first.
bool IsPoseLine(const std::vector<std::string>& cells, bool has_coordinate_system) {
  const auto num_numbers = std::count_if(cells.begin(), cells.end(), IsNumberCell);
  // Below a coordinate system the name may be a number.
  if (has_coordinate_system && cells.size() > 2) return num_numbers >= 2;
  const bool has_image = !cells.empty() && ((!IsNumberCell(cells[0]) && cells[0].find('#') != 0) ||
                                            std::any_of(cells.begin(), cells.end(), IsImageName));
  return has_image && num_numbers >= 2;
}

// A header may be a remark, which its first column is not.
std::string_view WithoutMark(std::string_view header) {
  const size_t first = header.find_first_not_of("# ");
  return first == std::string_view::npos ? std::string_view() : header.substr(first);
}

// The separator with which most of the line is known; the first of equals.
char SeparatorOf(std::string_view line) {
  return *std::max_element(kSeparators.begin(), kSeparators.end(), [&](char a, char b) {
    return NumKnownColumns(CellsOf(WithoutMark(line), a)) <
           NumKnownColumns(CellsOf(WithoutMark(line), b));
  });
}

bool IsHeader(std::string_view line) {
  return NumKnownColumns(CellsOf(WithoutMark(line), SeparatorOf(line))) >= kMinHeaderColumns;
}

std::optional<char> SeparatorOfPoses(std::string_view line, bool has_coordinate_system) {
  for (const char separator : {'\t', ';', ',', ' '}) {
    if (IsPoseLine(CellsOf(line, separator), has_coordinate_system)) return separator;
  }
  return std::nullopt;
}

// In a table separated by blanks, a name with blanks is one cell again.
void JoinName(std::vector<std::string>& cells) {
  const auto last = std::find_if(cells.begin(), cells.end(), IsImageName);
  if (last == cells.end() || last == cells.begin()) return;
  if (std::all_of(cells.begin(), last, IsNumberCell)) return;
  for (auto each = std::next(cells.begin()); each <= last; ++each) cells[0] += " " + *each;
  cells.erase(std::next(cells.begin()), std::next(last));
}

struct Beginning {
  // Index of the header among the lines; nothing if there is none.
  std::optional<size_t> header;
  // Index of the first line of poses, if there is no header.
  std::optional<size_t> poses;
};

Beginning BeginningOf(const std::vector<TextLine>& lines) {
  Beginning found;
  bool has_system = false;
  for (size_t i = 0; i < std::min(lines.size(), kMaxPreambleLines) && !found.header; ++i) {
    const std::string_view whole = lines[i].text;
    const std::string_view line = whole.substr(0, kLimits.poses.max_header_bytes);
    const bool names_system = !CoordinateSystemIn(line).empty();
    has_system = has_system || names_system;
    if (line.empty() || names_system) continue;
    if (IsHeader(line)) found.header = i;
    if (line[0] != '#' && !found.header && !found.poses && SeparatorOfPoses(line, has_system))
      found.poses = i;
    // Poses come before what looks like a header: another table follows.
    if (found.poses) break;
  }
  return found;
}

void ReadLines(const std::vector<TextLine>& lines, size_t first, Table& table) {
  size_t num_remarks = 0;
  for (size_t i = first; i < lines.size(); ++i) {
    const auto& [number, text] = lines[i];
    if (text.empty()) continue;
    if (text[0] == '#' && IsHeader(text)) {
      table.warnings.push_back("a second table begins at line " + std::to_string(number) +
                               ": it is not read");
      break;
    }
    if (text[0] == '#') {
      ++num_remarks;
      continue;
    }
    TableLine line{number, CellsOf(text, table.separator)};
    if (table.separator == ' ') JoinName(line.cells);
    const auto is_empty = [](const std::string& cell) { return cell.empty(); };
    if (!std::all_of(line.cells.begin(), line.cells.end(), is_empty)) {
      table.lines.push_back(std::move(line));
    }
  }
  if (num_remarks > 0) {
    table.warnings.push_back(std::to_string(num_remarks) +
                             " lines that begin with # are read as comments");
  }
}

}  // namespace

bool IsImageName(std::string_view cell) {
  const std::string lower = InLowerCase(cell);
  for (const char* const end : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".dng"}) {
    if (lower.ends_with(end)) return true;
  }
  return false;
}

std::string CoordinateSystemIn(std::string_view line) {
  line = Trimmed(line);
  const size_t first = line.find_first_not_of("# \t");
  if (first == std::string_view::npos) return "";
  const bool is_remark = line[0] == '#';
  line.remove_prefix(first);
  const std::string lower = InLowerCase(line.substr(0, line.find_first_of(",;\t")));
  for (const char* const begin : {"epsg:", "+proj=", "wgs84 utm"}) {
    if (lower.starts_with(begin)) return std::string(Trimmed(lower));
  }
  // WKT closes with the authority of the whole.
  const std::string_view authority = "\"EPSG\",\"";
  const size_t code = line.rfind(authority);
  if (!is_remark || code == std::string_view::npos) return "";
  line.remove_prefix(code + authority.size());
  return "epsg:" + std::string(line.substr(0, line.find('"')));
}

Table ReadTable(std::string_view text) {
  const std::vector<TextLine> lines = LinesOf(text, BlankLines::kKeep);
  Table table;
  const Beginning beginning = BeginningOf(lines);
  size_t first = beginning.header.value_or(beginning.poses.value_or(0));
  for (size_t i = 0; i < std::min(first, lines.size()); ++i) {
    const std::string system = CoordinateSystemIn(lines[i].text);
    if (!system.empty()) table.coordinate_system = system;
  }
  const auto is_content = [](const TextLine& line) { return !line.text.empty(); };
  if (beginning.header) {
    const auto& [number, header] = lines[first];
    table.separator = SeparatorOf(header);
    table.header = {number, CellsOf(WithoutMark(header), table.separator)};
    ++first;
  } else if (beginning.poses) {
    table.separator = SeparatorOfPoses(lines[first].text, !table.coordinate_system.empty()).value();
  } else if (const auto line = std::find_if(lines.begin(), lines.end(), is_content);
             line != lines.end()) {
    // What is neither is taken for a header, which then lacks columns.
    const auto plain = std::find_if(lines.begin(), lines.end(), [](const TextLine& each) {
      return !each.text.empty() && each.text[0] != '#';
    });
    const TextLine& header = plain == lines.end() ? *line : *plain;
    table.separator = SeparatorOf(header.text);
    table.header = {header.number, CellsOf(WithoutMark(header.text), table.separator)};
    return table;
  }
  ReadLines(lines, first, table);
  return table;
}

bool LooksLikeTable(std::string_view text) {
  const Beginning beginning = BeginningOf(LinesOf(text, BlankLines::kKeep));
  return beginning.header || beginning.poses;
}

}  // namespace freelsd
