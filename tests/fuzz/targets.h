// Everything that reads bytes from outside, one function each. A target returns whatever the bytes
// are: what is refused is refused by ApiError, std::invalid_argument or std::runtime_error, and
// what is taken keeps its promises. Anything else ends the process.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace freelsd {

struct FuzzTarget {
  // Also the folder of its seeds.
  const char* name;
  void (*run)(std::string_view bytes);
  // The longest input that is worth trying; 0: seeds only.
  size_t max_bytes = 4096;
};

const std::vector<FuzzTarget>& FuzzTargets();
// Runs a target once; says what was thrown and aborts where that is no refusal.
void RunSafely(const FuzzTarget& target, std::string_view bytes);

// By file.
void FuzzJsonBodies(std::string_view bytes);
void FuzzPoses(std::string_view bytes);
void FuzzSideFiles(std::string_view bytes);
void FuzzTelemetry(std::string_view bytes);
void FuzzLinks(std::string_view bytes);
void FuzzObstacles(std::string_view bytes);
void FuzzOpenAir(std::string_view bytes);
void FuzzQuery(std::string_view bytes);
void FuzzRequestHead(std::string_view bytes);
void FuzzMultipart(std::string_view bytes);
void FuzzImageHeader(std::string_view bytes);
void FuzzImageTags(std::string_view bytes);
void FuzzImageDecoding(std::string_view bytes);
void FuzzZip(std::string_view bytes);
void FuzzModel(std::string_view bytes);
void FuzzMapTile(std::string_view bytes);
void FuzzPhotoTile(std::string_view bytes);

}  // namespace freelsd
