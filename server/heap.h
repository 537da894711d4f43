// How the C library deals with freed memory. It keeps it for later, in pools of threads: flights
// come and go, and within half an hour twice as much is kept as is in use.
#pragma once

namespace freelsd {

// To be called before there are other threads.
void LimitHeapPools();
// What is free goes back to the system.
void ReturnFreedMemory();

}  // namespace freelsd
