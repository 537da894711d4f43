#include "server/work/heap.h"

#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace freelsd {

void LimitHeapPools() {
#if defined(__GLIBC__)
  constexpr int kMaxNumPools = 4;
  mallopt(M_ARENA_MAX, kMaxNumPools);
#endif
}

void ReturnFreedMemory() {
#if defined(__GLIBC__)
  malloc_trim(0);
#endif
}

}  // namespace freelsd
