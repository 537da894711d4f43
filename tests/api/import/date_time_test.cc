#include "api/import/date_time.h"

#include <string>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("date: EXIF and ISO forms, fractions and offsets") {
  CHECK(TimestampFromText("1970:01:01 00:00:01") == 1000000);
  // 2016-11-22 16:32:34 UTC is 1479832354 s.
  CHECK(TimestampFromText("2016:11:22 16:32:34.498032") == 1479832354498032);
  CHECK(TimestampFromText("2016-11-22T16:32:34Z") == 1479832354000000);
  CHECK(TimestampFromText("2016-11-22T18:32:34+02:00") == 1479832354000000);
  CHECK(FractionFromText("5") == 500000);
  CHECK(FractionFromText("05 ") == 50000);
  for (const char* const bad : {"",
                                "2016:13:22 16:32:34",
                                "2016:02:30 16:32:34",
                                "2016:11:22 25:00:00",
                                "    :  :     :  :  ",
                                "2016:11:22 16:32",
                                "2016:11:22 16:32:34.",
                                "2016:11:22 16:32:34 x"}) {
    CAPTURE(std::string(bad));
    CHECK_FALSE(TimestampFromText(bad));
  }
}

}  // namespace
}  // namespace freelsd
