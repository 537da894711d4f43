#include "server/supervisor.h"

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace freelsd {
namespace {

// Half of systemd's watchdog time; zero if systemd does not watch this process.
std::chrono::microseconds BeatPeriod() {
  const auto number = [](const char* name) {
    const char* const text = std::getenv(name);
    int64_t value = 0;
    if (text != nullptr) std::from_chars(text, text + std::strlen(text), value);
    return value;
  };
  const int64_t watched = number("WATCHDOG_PID");
  if (watched != 0 && watched != ::getpid()) return {};
  return std::chrono::microseconds(number("WATCHDOG_USEC") / 2);
}

}  // namespace

bool NotifySupervisor(const std::string& message) {
  const char* const path = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  if (path == nullptr || (path[0] != '/' && path[0] != '@')) return false;
  const std::string_view name = path;
  if (name.size() >= sizeof(address.sun_path)) return false;
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path, name.size());
  // The abstract namespace is written with a zero byte.
  if (name[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  const int descriptor = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return false;
  const ssize_t num_sent = ::sendto(descriptor,
                                    message.data(),
                                    message.size(),
                                    MSG_NOSIGNAL | MSG_DONTWAIT,
                                    reinterpret_cast<const sockaddr*>(&address),
                                    size);
  ::close(descriptor);
  return num_sent == static_cast<ssize_t>(message.size());
}

Heartbeat::Heartbeat(std::function<bool()> is_alive) : is_alive_(std::move(is_alive)) {
  const std::chrono::microseconds period = BeatPeriod();
  if (period.count() > 0) thread_ = std::thread([this, period] { Run(period); });
}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  ended_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Heartbeat::Run(std::chrono::microseconds period) {
  std::unique_lock lock(mutex_);
  while (!is_ended_) {
    lock.unlock();
    if (is_alive_()) NotifySupervisor("WATCHDOG=1");
    lock.lock();
    ended_.wait_for(lock, period, [this] { return is_ended_; });
  }
}

}  // namespace freelsd
