// Tells systemd how the service does (sd_notify), by a datagram to $NOTIFY_SOCKET; does nothing
// where there is none.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace freelsd {

// One message, "READY=1" for instance; whether it was sent.
bool NotifySupervisor(const std::string& message);

// Says "WATCHDOG=1" twice in each $WATCHDOG_USEC while `is_alive` answers true: where it does not,
// or hangs, systemd ends the service and starts it anew.
class Heartbeat {
 public:
  explicit Heartbeat(std::function<bool()> is_alive);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

 private:
  void Run(std::chrono::microseconds period);

  std::function<bool()> is_alive_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_ended_ = false;
  std::thread thread_;
};

}  // namespace freelsd
