#include "api/import/poses/csv.h"

#include <doctest/doctest.h>

namespace freelsd {
namespace {

TEST_CASE("csv: quotes, doubled quotes, line ends, blank lines, line numbers") {
  const auto lines = ParseCsv("a,\"b,\"\"c\"\"\"\r\n\r\n\"x\ny\",\"\"\nlast,");
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].cells == std::vector<std::string>{"a", "b,\"c\""});
  CHECK(lines[1].cells == std::vector<std::string>{"x\ny", ""});
  CHECK(lines[1].number == 3);
  CHECK(lines[2].cells == std::vector<std::string>{"last", ""});
  CHECK(lines[2].number == 5);
  CHECK_THROWS(ParseCsv("a,\"b"));
  CHECK(ParseCsv("a;b\n1;2")[1].cells.size() == 2);
}

}  // namespace
}  // namespace freelsd
