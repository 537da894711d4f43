// Checks the messages to systemd, received over a socket of our own.
#include "server/supervisor.h"

#include <array>
#include <cstdlib>

#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/server/child.h"

namespace freelsd {
namespace {

// Receives what is sent to it, and is named in the environment while it lives.
class Supervisor {
 public:
  explicit Supervisor(const std::filesystem::path& path)
      : descriptor_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof(address.sun_path) - 1);
    REQUIRE(::bind(descriptor_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0);
    const timeval timeout{20, 0};
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout));
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "20000", 1);
  }
  ~Supervisor() {
    ::close(descriptor_);
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // Empty when nothing comes.
  std::string Receive() const {
    std::array<char, 256> bytes;
    const ssize_t num_read = ::recv(descriptor_, bytes.data(), bytes.size(), 0);
    return num_read > 0 ? std::string(bytes.data(), static_cast<size_t>(num_read)) : "";
  }

 private:
  int descriptor_;
};

TEST_CASE("supervisor: it is told when the service is ready, that it lives, and that it stops") {
  const TemporaryFolder folder;
  const Supervisor supervisor(folder.path() / "notify");
  Child child({folder.path()});
  CHECK(supervisor.Receive() == "READY=1");
  CHECK(supervisor.Receive() == "WATCHDOG=1");
  CHECK(supervisor.Receive() == "WATCHDOG=1");
  child.Stop(SIGTERM);
  std::string last = supervisor.Receive();
  while (last == "WATCHDOG=1") last = supervisor.Receive();
  CHECK(last == "STOPPING=1");
}

TEST_CASE("supervisor: a service that is not alive says nothing") {
  const TemporaryFolder folder;
  const Supervisor supervisor(folder.path() / "notify");
  std::atomic<int> num_asked{0};
  {
    const Heartbeat heartbeat([&num_asked] { return ++num_asked > 3; });
    CHECK(supervisor.Receive() == "WATCHDOG=1");
  }
  CHECK(num_asked >= 4);
}

TEST_CASE("supervisor: without one nothing is sent") { CHECK_FALSE(NotifySupervisor("READY=1")); }

}  // namespace
}  // namespace freelsd
