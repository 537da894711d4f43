#include <doctest/doctest.h>

#include "api/import/import.h"

namespace freelsd {
namespace {

TEST_CASE("id: only the contract's characters, 1 to 128 of them") {
  CHECK(IsValidId("IMG_1417.JPG"));
  CHECK(IsValidId(std::string(128, 'a')));
  CHECK_FALSE(IsValidId(std::string(129, 'a')));
  for (const char* const bad : {"", ".", "..", "a/b", "a b", "\xc3\xa9", "a\n", "a%2e"}) {
    CAPTURE(std::string(bad));
    CHECK_FALSE(IsValidId(bad));
  }
}

TEST_CASE("id: from a file name every other character becomes one underscore") {
  CHECK(IdFromFileName("IMG_1417.JPG") == "IMG_1417.JPG");
  CHECK(IdFromFileName("day 1/IMG (2).jpg") == "IMG__2_.jpg");
  CHECK(IdFromFileName("C:\\photos\\a.jpg") == "a.jpg");
  CHECK(IdFromFileName("pr\xc3\xa9.jpg") == "pr_.jpg");
  for (const char* const odd : {"", ".", "..", "a/", "a/..", "\x80"}) {
    CAPTURE(std::string(odd));
    CHECK(IsValidId(IdFromFileName(odd)));
  }
  CHECK(IsValidId(IdFromFileName(std::string(500, 'x'))));
}

TEST_CASE("sha256: the standard's test vectors") {
  CHECK(Sha256Hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(Sha256Hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace freelsd
