// Tables as programs and spreadsheets write them: separated by commas, semicolons, tabs or blanks,
// with or without a header, below remarks and a coordinate system. Private to poses/.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct TableLine {
  // From 1.
  int number = 0;
  // Without blanks around them and without quotes.
  std::vector<std::string> cells;
};

struct Table {
  // Empty if the table has none.
  std::optional<TableLine> header;
  std::vector<TableLine> lines;
  // ' ' stands for any number of blanks.
  char separator = ',';
  // The line that names a coordinate system; empty if there is none.
  std::string coordinate_system;
  std::vector<std::string> warnings;
};

// `text` is UTF-8. Lines that begin with # are remarks, and so are the lines before a header. A
// second header ends the table. A quote that is never closed ends with its line.
Table ReadTable(std::string_view text);
// True if the text has a header with known columns, or if its first line begins with an image.
bool LooksLikeTable(std::string_view text);
// The coordinate system that the line names: "EPSG:4326", "WGS84 UTM 32N", "+proj=utm ...", or the
// last authority of a WKT. Empty if it names none.
std::string CoordinateSystemIn(std::string_view line);
// True for a name that ends as that of a photograph.
bool IsImageName(std::string_view cell);

}  // namespace freelsd
