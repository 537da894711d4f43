// How the C library deals with freed memory. It keeps it for later, in pools of threads: where
// flights come and go, far more is kept in the end than is in use.
#pragma once

namespace freelsd {

// To be called before there are other threads.
void LimitHeapPools();
// What is free goes back to the system.
void ReturnFreedMemory();

}  // namespace freelsd
