// Reports the state of the service to systemd (sd_notify) by datagrams to $NOTIFY_SOCKET. Does
// nothing if that variable is not set.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace freelsd {

// Sends one message, for example "READY=1". True if it was sent.
bool NotifySupervisor(const std::string& message);

// Sends "WATCHDOG=1" twice in each $WATCHDOG_USEC while `is_alive` returns true. If `is_alive`
// returns false or hangs, systemd restarts the service. A thread of its own calls `is_alive`.
class Heartbeat {
 public:
  explicit Heartbeat(std::function<bool()> is_alive);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

 private:
  void Run(std::chrono::microseconds period);

  std::function<bool()> is_alive_;
  // Guards is_ended_.
  std::mutex mutex_;
  std::condition_variable ended_;
  bool is_ended_ = false;
  std::thread thread_;
};

}  // namespace freelsd
