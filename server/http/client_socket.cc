#include "server/http/client_socket.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace freelsd {
namespace {

constexpr std::chrono::seconds kWriteTimeout{10};
constexpr std::chrono::seconds kLingerTime{2};
// Most bytes that Linger reads from a client.
constexpr size_t kMaxLingerBytes = size_t{64} << 20;

bool WaitFor(int descriptor, short events, SteadyTime deadline) {
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    pollfd entry{descriptor, events, 0};
    const int timeout_ms = static_cast<int>(std::max<int64_t>(left.count(), 0));
    const int num_ready = ::poll(&entry, 1, timeout_ms);
    if (num_ready > 0) return true;
    if (num_ready == 0 || errno != EINTR) return false;
  }
}

}  // namespace

ClientSocket::ClientSocket(int descriptor) : descriptor_(descriptor) {
  // Without it an answer on a kept connection can wait 40 ms for the client's delayed
  // acknowledgement.
  const int on = 1;
  ::setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

ClientSocket::~ClientSocket() {
  ::shutdown(descriptor_, SHUT_RDWR);
  ::close(descriptor_);
}

bool ClientSocket::IsReadableBefore(SteadyTime deadline) const {
  return WaitFor(descriptor_, POLLIN, deadline);
}

size_t ClientSocket::Read(char* bytes, size_t size, SteadyTime deadline) const {
  while (IsReadableBefore(deadline)) {
    const ssize_t num_read = ::recv(descriptor_, bytes, size, MSG_DONTWAIT);
    if (num_read >= 0) return static_cast<size_t>(num_read);
    if (errno != EINTR && errno != EAGAIN) return 0;
  }
  return 0;
}

bool ClientSocket::Write(std::string_view bytes) const {
  SteadyTime deadline = std::chrono::steady_clock::now() + kWriteTimeout;
  while (!bytes.empty()) {
    if (!WaitFor(descriptor_, POLLOUT, deadline)) return false;
    const ssize_t num_sent =
        ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (num_sent < 0 && errno != EINTR && errno != EAGAIN) return false;
    if (num_sent > 0) {
      bytes.remove_prefix(static_cast<size_t>(num_sent));
      deadline = std::chrono::steady_clock::now() + kWriteTimeout;
    }
  }
  return true;
}

void ClientSocket::Linger() const {
  ::shutdown(descriptor_, SHUT_WR);
  const SteadyTime deadline = std::chrono::steady_clock::now() + kLingerTime;
  std::array<char, 65536> ignored;
  for (size_t total = 0; total < kMaxLingerBytes;) {
    const size_t num_read = Read(ignored.data(), ignored.size(), deadline);
    if (num_read == 0) return;
    total += num_read;
  }
}

}  // namespace freelsd
