#include "api/import/number_text.h"

#include <string>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("numbers in tags: signs, fractions, and nothing that is not finite") {
  CHECK(NumberFromText(" +121.6 ") == 121.6);
  CHECK(NumberFromText("1/4") == 0.25);
  for (const char* const bad : {"", "nan", "inf", "1e999", "1/0", "12m", "0x10", "--1"}) {
    CAPTURE(std::string(bad));
    CHECK_FALSE(NumberFromText(bad));
  }
}

}  // namespace
}  // namespace freelsd
