#include "server/jobs/heap.h"

#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace freelsd {

void LimitHeapPools() {
#if defined(__GLIBC__)
  constexpr int kMaxNumPools = 4;
  mallopt(M_ARENA_MAX, kMaxNumPools);
  // Rasters go back to the system at once. By default the library learns to keep those of up to
  // 32 MiB, and after an evaluation half of its memory was gaps.
  constexpr int kMinMappedBytes = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, kMinMappedBytes);
#endif
}

void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace freelsd
