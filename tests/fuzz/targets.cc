#include "tests/fuzz/targets.h"

#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>

#include "api/api.h"

namespace freelsd {
namespace {

bool IsRefusal(const std::exception& error) {
  return dynamic_cast<const std::invalid_argument*>(&error) != nullptr ||
         dynamic_cast<const std::runtime_error*>(&error) != nullptr;
}

}  // namespace

const std::vector<FuzzTarget>& FuzzTargets() {
  static const std::vector<FuzzTarget> kTargets{{"json", FuzzJsonBodies},
                                                {"poses", FuzzPoses},
                                                {"side_files", FuzzSideFiles},
                                                {"telemetry", FuzzTelemetry},
                                                {"links", FuzzLinks},
                                                {"obstacles", FuzzObstacles},
                                                {"open_air", FuzzOpenAir},
                                                {"query", FuzzQuery, 512},
                                                {"request_head", FuzzRequestHead},
                                                {"multipart", FuzzMultipart},
                                                {"image_header", FuzzImageHeader, 20000},
                                                {"image_tags", FuzzImageTags, 20000},
                                                {"image_decoding", FuzzImageDecoding, 20000},
                                                {"zip", FuzzZip, 20000},
                                                {"model", FuzzModel, 0},
                                                {"map_tile", FuzzMapTile, 20000},
                                                {"photo_tile", FuzzPhotoTile, 20000}};
  return kTargets;
}

void RunSafely(const FuzzTarget& target, std::string_view bytes) {
  try {
    target.run(bytes);
  } catch (const std::exception& error) {
    if (IsRefusal(error)) return;
    std::fprintf(stderr, "%s: %s is no refusal\n", target.name, error.what());
    std::abort();
  }
}

}  // namespace freelsd
