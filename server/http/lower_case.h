// Lower case of ASCII letters, for names that HTTP compares without case.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace freelsd {

inline std::string LowerCase(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return lower;
}

}  // namespace freelsd
