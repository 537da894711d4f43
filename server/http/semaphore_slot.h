#pragma once

#include <semaphore>

namespace freelsd {

// Holds one place of a semaphore. The constructor waits for it.
class SemaphoreSlot {
 public:
  explicit SemaphoreSlot(std::counting_semaphore<>& semaphore) : semaphore_(semaphore) {
    semaphore_.acquire();
  }
  ~SemaphoreSlot() { semaphore_.release(); }
  SemaphoreSlot(const SemaphoreSlot&) = delete;
  SemaphoreSlot& operator=(const SemaphoreSlot&) = delete;

 private:
  std::counting_semaphore<>& semaphore_;
};

}  // namespace freelsd
