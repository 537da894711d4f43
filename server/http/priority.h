// How threads share the processors.
#pragma once

#include <semaphore>

namespace freelsd {

// Lowers the priority of the calling thread and of all threads that it starts later: those of the
// engine do not delay answers to emergencies.
void GiveWay();

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
