// Joins what several threads write at the same time into one commit: a commit waits for the disk,
// and most of what a small one costs is the transaction around it.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>
#include <vector>

namespace freelsd {

// Thread-safe.
template <typename Item>
class GroupedWrites {
 public:
  // Calls `write` with a group that holds the item, in this thread or in that of another item, and
  // returns when the group is written. One group is written at a time; who comes meanwhile waits
  // for the next. Throws what `write` threw for the group.
  template <typename Write>
  void Run(Item& item, const Write& write) {
    Waiting own(&item);
    std::unique_lock lock(mutex_);
    waiting_.push_back(&own);
    changed_.wait(lock, [&] { return own.is_written || !is_writing_; });
    if (!own.is_written) WriteAll(lock, write);
    if (own.failure) std::rethrow_exception(own.failure);
  }

 private:
  struct Waiting {
    explicit Waiting(Item* given) : item(given) {}

    Item* item;
    bool is_written = false;
    std::exception_ptr failure;
  };

  template <typename Write>
  void WriteAll(std::unique_lock<std::mutex>& lock, const Write& write) {
    is_writing_ = true;
    const std::vector<Waiting*> group = std::exchange(waiting_, {});
    lock.unlock();
    std::exception_ptr failure;
    try {
      std::vector<Item*> items;
      items.reserve(group.size());
      for (const Waiting* const each : group) items.push_back(each->item);
      write(items);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    is_writing_ = false;
    for (Waiting* const each : group) {
      each->is_written = true;
      each->failure = failure;
    }
    changed_.notify_all();
  }

  // Guards the fields below.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Waiting*> waiting_;
  bool is_writing_ = false;
};

}  // namespace freelsd
