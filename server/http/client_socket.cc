#include "server/http/client_socket.h"

#include <algorithm>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace freelsd {
namespace {

constexpr std::chrono::seconds kWriteTimeout{10};
// A client that acknowledges nothing for that long has vanished. Without it the kernel waits a
// quarter of an hour.
constexpr std::chrono::milliseconds kAcknowledgementTimeout{20000};

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

bool IsOnlyBusy(int error) { return error == EINTR || error == EAGAIN; }

}  // namespace

ClientSocket::ClientSocket(int descriptor) : descriptor_(descriptor) {
  // Without it an answer on a kept connection can wait 40 ms for the client's delayed
  // acknowledgement.
  const int on = 1;
  ::setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  const auto timeout_ms = static_cast<unsigned int>(kAcknowledgementTimeout.count());
  ::setsockopt(descriptor_, IPPROTO_TCP, TCP_USER_TIMEOUT, &timeout_ms, sizeof(timeout_ms));
}

ClientSocket::~ClientSocket() {
  ::shutdown(descriptor_, SHUT_RDWR);
  ::close(descriptor_);
}

std::optional<size_t> ClientSocket::ReadNow(char* bytes, size_t size) const {
  const ssize_t num_read = ::recv(descriptor_, bytes, size, MSG_DONTWAIT);
  if (num_read >= 0) return static_cast<size_t>(num_read);
  if (IsOnlyBusy(errno)) return std::nullopt;
  return 0;
}

std::optional<size_t> ClientSocket::WriteNow(std::string_view bytes) const {
  const ssize_t num_sent =
      ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (num_sent >= 0) return static_cast<size_t>(num_sent);
  if (IsOnlyBusy(errno)) return 0;
  return std::nullopt;
}

size_t ClientSocket::Read(char* bytes, size_t size, SteadyTime deadline) const {
  while (WaitFor(descriptor_, POLLIN, deadline)) {
    if (const std::optional<size_t> num_read = ReadNow(bytes, size)) return *num_read;
  }
  return 0;
}

bool ClientSocket::Write(std::string_view bytes) const {
  SteadyTime deadline = std::chrono::steady_clock::now() + kWriteTimeout;
  while (!bytes.empty()) {
    if (!WaitFor(descriptor_, POLLOUT, deadline)) return false;
    const std::optional<size_t> num_sent = WriteNow(bytes);
    if (!num_sent) return false;
    if (*num_sent == 0) continue;
    bytes.remove_prefix(*num_sent);
    deadline = std::chrono::steady_clock::now() + kWriteTimeout;
  }
  return true;
}

bool ClientSocket::HasEnded() const {
  pollfd entry{descriptor_, POLLRDHUP, 0};
  return ::poll(&entry, 1, 0) > 0;
}

bool ClientSocket::HasBytes() const {
  char next = 0;
  return ::recv(descriptor_, &next, 1, MSG_DONTWAIT | MSG_PEEK) > 0;
}

std::string ClientSocket::PeerNetwork() const {
  sockaddr_storage peer{};
  socklen_t size = sizeof(peer);
  if (::getpeername(descriptor_, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return {};
  const auto bytes_of = [](const auto& address, size_t num_bytes) {
    return std::string(reinterpret_cast<const char*>(&address), num_bytes);
  };
  if (peer.ss_family == AF_INET) {
    return bytes_of(reinterpret_cast<const sockaddr_in*>(&peer)->sin_addr, sizeof(in_addr));
  }
  if (peer.ss_family != AF_INET6) return {};
  const in6_addr& address = reinterpret_cast<const sockaddr_in6*>(&peer)->sin6_addr;
  constexpr size_t kNetworkBytes = 8;
  return bytes_of(address, IN6_IS_ADDR_V4MAPPED(&address) ? sizeof(address) : kNetworkBytes);
}

void ClientSocket::EndWriting() const { ::shutdown(descriptor_, SHUT_WR); }

void ClientSocket::EndReading() const { ::shutdown(descriptor_, SHUT_RD); }

}  // namespace freelsd
