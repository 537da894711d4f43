#include "server/http/priority.h"

#include <algorithm>
#include <chrono>

#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace freelsd {

void GiveWay() {
#if defined(__linux__)
  // About a tenth of the processor share of a normal thread. On Linux, 0 means the calling thread.
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNiceness);
#endif
}

void LongQueue::Enter(const StopIfUnwanted& stop_if_unwanted) {
  uint64_t ticket = 0;
  {
    const std::lock_guard lock(mutex_);
    const bool must_wait = num_computing_ >= limits_.max_num_computing || !waiting_.empty();
    if (must_wait && static_cast<int>(waiting_.size()) >= limits_.max_num_waiting) {
      throw ApiError("TooManyRequests",
                     "too many requests that compute for long: " + std::to_string(waiting_.size()) +
                         " wait already");
    }
    ticket = next_ticket_++;
    waiting_.push_back(ticket);
  }
  try {
    Await(ticket, stop_if_unwanted);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    std::erase(waiting_, ticket);
    changed_.notify_all();
    throw;
  }
}

void LongQueue::Await(uint64_t ticket, const StopIfUnwanted& stop_if_unwanted) {
  // A client that leaves wakes nobody.
  constexpr std::chrono::milliseconds kLookPeriod{50};
  const auto is_next = [&] {
    return num_computing_ < limits_.max_num_computing && waiting_.front() == ticket;
  };
  while (true) {
    stop_if_unwanted();
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, kLookPeriod, is_next)) continue;
    waiting_.pop_front();
    ++num_computing_;
    return changed_.notify_all();
  }
}

void LongQueue::Leave() {
  const std::lock_guard lock(mutex_);
  --num_computing_;
  changed_.notify_all();
}

}  // namespace freelsd
