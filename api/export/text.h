// Private to export/. Formats numbers and text for exported files.
#pragma once

#include <string>

namespace freelsd {

std::string FixedText(double number, int num_decimals);
// The text with a space for each line break and other control character.
std::string OneLine(const std::string& text);
// The text of a cell. An apostrophe stands before what spreadsheets take for a formula.
std::string CellText(const std::string& text);
// Escapes text for XML and HTML content and attributes.
std::string EscapeXml(const std::string& text);

}  // namespace freelsd
