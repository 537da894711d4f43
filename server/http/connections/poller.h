// Waits for sockets, and for other threads that wake it. A wrapper of epoll and eventfd.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

namespace freelsd {

// Owns a file descriptor.
class OwnDescriptor {
 public:
  explicit OwnDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~OwnDescriptor();
  OwnDescriptor(const OwnDescriptor&) = delete;
  OwnDescriptor& operator=(const OwnDescriptor&) = delete;
  int value() const { return descriptor_; }

 private:
  int descriptor_;
};

// Ends the wait of a Poller. Thread-safe; may outlive the Poller.
class Waker {
 public:
  Waker();
  void Wake() const;
  // Cancels all calls of Wake so far.
  void Clear() const;
  int descriptor() const { return event_.value(); }

 private:
  OwnDescriptor event_;
};

// Only one thread may use it.
class Poller {
 public:
  enum class Interest { kRead, kWrite, kReadAndWrite };

  explicit Poller(std::shared_ptr<Waker> waker);

  // Waits for the descriptor once. After Ready has returned it, the descriptor is ignored until Arm
  // is called again. Closing a descriptor removes it.
  void Arm(int descriptor, Interest interest);
  // The armed descriptors that are ready; none if the waker or the timeout ended the wait.
  std::vector<int> Ready(std::chrono::milliseconds timeout);

 private:
  OwnDescriptor epoll_;
  std::shared_ptr<Waker> waker_;
};

}  // namespace freelsd
