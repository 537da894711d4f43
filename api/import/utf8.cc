#include "api/import/utf8.h"

#include <algorithm>

#include <iconv.h>

namespace freelsd {
namespace {

// Bytes from which UTF-16 without a mark is recognised: every second one is 0 in Latin script.
constexpr size_t kNumLookedAt = 64;

bool AreMostlyZero(std::string_view text, size_t first) {
  size_t num = 0, num_zero = 0;
  for (size_t i = first; i < std::min(text.size(), kNumLookedAt); i += 2) {
    ++num;
    num_zero += text[i] == '\0';
  }
  return num > 1 && num_zero * 2 > num;
}

std::string FromUtf16(std::string_view text, const char* encoding) {
  const iconv_t converter = ::iconv_open("UTF-8", encoding);
  std::string read(text.substr(0, text.size() / 2 * 2)), utf8(2 * text.size(), '\0');
  char* from = read.data();
  char* to = utf8.data();
  size_t num_from = read.size(), num_to = utf8.size();
  while (num_from > 1 && ::iconv(converter, &from, &num_from, &to, &num_to) == size_t(-1)) {
    // Half of a pair.
    if (num_to == 0 || num_from < 2) break;
    from += 2;
    num_from -= 2;
    *to++ = '?';
    --num_to;
  }
  ::iconv_close(converter);
  utf8.resize(utf8.size() - num_to);
  return utf8;
}

}  // namespace

std::string ToUtf8(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) return std::string(text.substr(3));
  if (text.starts_with("\xFF\xFE")) return FromUtf16(text.substr(2), "UTF-16LE");
  if (text.starts_with("\xFE\xFF")) return FromUtf16(text.substr(2), "UTF-16BE");
  if (AreMostlyZero(text, 1)) return FromUtf16(text, "UTF-16LE");
  if (AreMostlyZero(text, 0)) return FromUtf16(text, "UTF-16BE");
  return std::string(text);
}

}  // namespace freelsd
