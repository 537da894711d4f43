// Limits the freed memory that the C library (glibc) keeps. It has several pools (arenas), which
// the threads share. With many flights over time, the pools grow far beyond the memory in use.
#pragma once

namespace freelsd {

// Limits the number of pools. Call it before other threads start.
void LimitHeapPools();
// Returns free memory to the system.
void ReturnFreedMemory();

}  // namespace freelsd
