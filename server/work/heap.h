// Limits the freed memory that the C library keeps. It keeps such memory in one pool for each group
// of threads; with many flights over time, the pools grow far beyond the memory in use.
#pragma once

namespace freelsd {

// Limits the number of pools. Call it before other threads start.
void LimitHeapPools();
// Returns free memory to the system.
void ReturnFreedMemory();

}  // namespace freelsd
