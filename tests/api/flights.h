// The recorded flights, where they are at hand.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include <doctest/doctest.h>

namespace freelsd {

// $FREELSD_DATA/flights; says so when there is none.
inline std::optional<std::filesystem::path> FlightsFolder() {
  const char* const data = std::getenv("FREELSD_DATA");
  if (data != nullptr) return std::filesystem::path(data) / "flights";
  MESSAGE("skipped: FREELSD_DATA is not set");
  return std::nullopt;
}

inline std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace freelsd
