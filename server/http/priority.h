// How threads share the processors.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <semaphore>

#include "api/api.h"

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

// Throws if nobody waits for the result of a computation any more. The computation calls it at
// least every few milliseconds.
using StopIfUnwanted = std::function<void()>;

// Requests of one kind that compute for long. Few of them compute at the same time, and a few more
// wait, in the order of their arrival. All others are refused at once. Thread-safe.
class LongQueue {
 public:
  explicit LongQueue(const LongQueueLimits& limits) : limits_(limits) {}

 private:
  friend class LongPlace;

  void Enter(const StopIfUnwanted& stop_if_unwanted);
  void Await(uint64_t ticket, const StopIfUnwanted& stop_if_unwanted);
  void Leave();

  LongQueueLimits limits_;
  // Guards num_computing_, waiting_ and next_ticket_.
  std::mutex mutex_;
  std::condition_variable changed_;
  int num_computing_ = 0;
  std::deque<uint64_t> waiting_;
  uint64_t next_ticket_ = 0;
};

// A place among those that compute. The constructor waits for it. It throws ApiError
// TooManyRequests if too many wait already, and what `stop_if_unwanted` throws meanwhile.
class LongPlace {
 public:
  LongPlace(LongQueue& queue, const StopIfUnwanted& stop_if_unwanted) : queue_(queue) {
    queue_.Enter(stop_if_unwanted);
  }
  ~LongPlace() { queue_.Leave(); }
  LongPlace(const LongPlace&) = delete;
  LongPlace& operator=(const LongPlace&) = delete;

 private:
  LongQueue& queue_;
};

// The queues of a process. One kind does not keep another one from its places.
struct LongQueues {
  LongQueue reach{kLimits.concurrency.reach};
  // The insurance of routes, and legs to fly next.
  LongQueue routes{kLimits.concurrency.routes};
  // What is planned or drawn for one site or place.
  LongQueue plans{kLimits.concurrency.plans};
  // Reports, and files of whole maps.
  LongQueue files{kLimits.concurrency.files};

  // Threads that all of these requests hold together, at most.
  static constexpr int MaxNumThreads() {
    const ConcurrencyLimits& limits = kLimits.concurrency;
    int num_threads = 0;
    for (const LongQueueLimits& each : {limits.reach, limits.routes, limits.plans, limits.files}) {
      num_threads += each.max_num_computing + each.max_num_waiting;
    }
    return num_threads;
  }
};

}  // namespace freelsd
