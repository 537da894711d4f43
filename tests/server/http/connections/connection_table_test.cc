#include "server/http/connections/connection_table.h"

#include <doctest/doctest.h>
#include <sys/socket.h>
#include <unistd.h>

namespace freelsd {
namespace {

using Phase = ClientConnection::Phase;

// Connections to nobody.
struct Fixture {
  RequestRules rules;
  ConnectionTable table;
  SteadyTime now = std::chrono::steady_clock::now();

  // Its descriptor.
  int Add(Phase phase, int age_s) {
    int pair[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair) == 0);
    ::close(pair[1]);
    auto connection = std::make_unique<ClientConnection>(pair[0], rules);
    connection->phase = phase;
    connection->since = now - std::chrono::seconds(age_s);
    table.Add(std::move(connection));
    return pair[0];
  }
};

TEST_CASE("connection table: the longest idle is closed first, and what is served never") {
  Fixture fixture;
  const int served = fixture.Add(Phase::kServing, 100);
  const int live = fixture.Add(Phase::kLive, 100);
  const int writing = fixture.Add(Phase::kWriting, 50);
  const int head = fixture.Add(Phase::kHead, 50);
  const int young = fixture.Add(Phase::kIdle, 1);
  const int old = fixture.Add(Phase::kIdle, 10);
  for (const int next : {old, young, head, writing, live}) {
    CHECK(fixture.table.Find(next) != nullptr);
    CHECK(fixture.table.CloseOne());
    CHECK(fixture.table.Find(next) == nullptr);
  }
  CHECK_FALSE(fixture.table.CloseOne());
  CHECK(fixture.table.Find(served) != nullptr);
}

TEST_CASE("connection table: answers that nobody reads are dropped, the longest waiting first") {
  Fixture fixture;
  const int young = fixture.Add(Phase::kWriting, 1);
  const int old = fixture.Add(Phase::kWriting, 10);
  for (const int each : {young, old}) {
    fixture.table.Find(each)->output.Append(std::string(1000, 'x'));
  }
  fixture.table.LimitUnsent(2000);
  CHECK(fixture.table.size() == 2);
  fixture.table.LimitUnsent(1999);
  CHECK(fixture.table.Find(old) == nullptr);
  CHECK(fixture.table.Find(young) != nullptr);
}

TEST_CASE("connection table: a connection whose turn fails is closed, the others go on") {
  Fixture fixture;
  const int bad = fixture.Add(Phase::kIdle, 1);
  const int good = fixture.Add(Phase::kIdle, 1);
  int num_called = 0;
  fixture.table.ForEach(Phase::kIdle, [&](ClientConnection& connection) {
    ++num_called;
    if (connection.socket.descriptor() == bad) throw std::bad_alloc();
  });
  CHECK(num_called == 2);
  CHECK(fixture.table.Find(bad) == nullptr);
  CHECK(fixture.table.Find(good) != nullptr);
}

}  // namespace
}  // namespace freelsd
