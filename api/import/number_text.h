// Parsing of numbers in image tags and in files beside the images.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace freelsd {

// Reads "+121.6", "1/3" or " 12 ". Nothing if the text is no finite number.
std::optional<double> NumberFromText(std::string_view text);
// The text without leading and trailing blanks and line ends.
std::string_view Trimmed(std::string_view text);
// Of ASCII; other letters stay.
std::string InLowerCase(std::string_view text);

}  // namespace freelsd
