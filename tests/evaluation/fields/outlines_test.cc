// Texts with outlines: what is read, and what a mistake is called.
#include "tests/evaluation/fields/outlines.h"

#include <stdexcept>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

// What the text is refused with; "" if it is not.
std::string ErrorOf(const std::string& text) {
  try {
    ParseOutlines(text, "flight.txt");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("outlines: ground and things are read, comments and empty lines are not") {
  const std::vector<Outline> outlines = ParseOutlines(
      "# by eye\n\nF1 land IMG_1 0 1 2 3 4 5.5 6  # meadow\nW1 wall IMG_2 1.2 10 20 30 40\n",
      "flight.txt");
  REQUIRE(outlines.size() == 2);
  CHECK(outlines[0].id == "F1");
  CHECK(outlines[0].kind == OutlineKind::kLand);
  CHECK(outlines[0].photograph == "IMG_1");
  REQUIRE(outlines[0].corners_in_image.size() == 3);
  CHECK(outlines[0].corners_in_image[2] == Eigen::Vector2d(5.5, 6.0));
  CHECK(outlines[1].kind == OutlineKind::kWall);
  CHECK(outlines[1].height_m == 1.2);
}

TEST_CASE("outlines: a mistake is named with file and line") {
  CHECK(ErrorOf("F1 land IMG_1 0 1 2 3 4 5 6\n\nF2 lawn IMG_1 0 1 2 3 4 5 6\n") ==
        "flight.txt:3: \"lawn\" is not a kind");
  CHECK(ErrorOf("F1 land IMG_1 0 1 2 3 4 5\n") == "flight.txt:1: the last corner has no row");
  CHECK(ErrorOf("F1 land IMG_1 0 1 2 3 4\n") ==
        "flight.txt:1: ground needs at least three corners");
  CHECK(ErrorOf("F1 wall IMG_1 tall 1 2 3 4\n") == "flight.txt:1: \"tall\" is not a number");
  CHECK(ErrorOf("F1 wall IMG_1 -1 1 2 3 4\n") == "flight.txt:1: the height is negative");
  CHECK(ErrorOf("F1 land IMG_1 0 1 2 3 4 5 6\nF1 tree IMG_2 5 1 2 3 4 5 6\n") ==
        "flight.txt:2: F1 has another kind above");
  CHECK(ErrorOf("F1 wall\n") ==
        "flight.txt:1: expected ID KIND PHOTOGRAPH HEIGHT_M and at least two corners");
}

}  // namespace
}  // namespace freelsd
