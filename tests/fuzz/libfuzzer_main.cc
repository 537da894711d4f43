// The same targets below libFuzzer, one per process: FREELSD_FUZZ_TARGET names it.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/fuzz/targets.h"

namespace {

const freelsd::FuzzTarget& Target() {
  const char* const name = std::getenv("FREELSD_FUZZ_TARGET");
  for (const freelsd::FuzzTarget& target : freelsd::FuzzTargets()) {
    if (name != nullptr && std::strcmp(name, target.name) == 0) return target;
  }
  std::fprintf(stderr, "FREELSD_FUZZ_TARGET must name a folder of tests/fuzz/seeds\n");
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const freelsd::FuzzTarget& target = Target();
  if (size > target.max_bytes) return 0;
  freelsd::RunSafely(target, {reinterpret_cast<const char*>(bytes), size});
  return 0;
}
