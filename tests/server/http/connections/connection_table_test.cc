#include "server/http/connections/connection_table.h"

#include <cmath>
#include <string>

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
  int Add(Phase phase, double age_s, const std::string& peer = "", bool is_pipelined = false) {
    int pair[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair) == 0);
    ::close(pair[1]);
    auto connection = std::make_unique<ClientConnection>(pair[0], rules);
    connection->phase = phase;
    connection->since =
        now - std::chrono::milliseconds(static_cast<int64_t>(std::lround(1000.0 * age_s)));
    connection->peer = peer;
    connection->is_pipelined = is_pipelined;
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
  const int queued = fixture.Add(Phase::kQueued, 50);
  for (const int next : {old, young, writing, head, live, queued}) {
    CHECK(fixture.table.Find(next) != nullptr);
    CHECK(fixture.table.CloseOne());
    CHECK(fixture.table.Find(next) == nullptr);
  }
  CHECK_FALSE(fixture.table.CloseOne());
  CHECK(fixture.table.Find(served) != nullptr);
}

TEST_CASE("connection table: who has just connected stays, a pipelining and a slow reader go") {
  Fixture fixture;
  const int fresh = fixture.Add(Phase::kIdle, 0.01);
  const int pipelined = fixture.Add(Phase::kQueued, 0.001, "", true);
  const int writing = fixture.Add(Phase::kWriting, 0.001);
  for (const int next : {pipelined, writing}) {
    CHECK(fixture.table.CloseOne());
    CHECK(fixture.table.Find(next) == nullptr);
  }
  CHECK(fixture.table.Find(fresh) != nullptr);
}

TEST_CASE("connection table: an address beyond its limit loses its own, a full table the most") {
  constexpr auto kOfAddress = static_cast<int>(kLimits.connection.max_num_connections_of_address);
  constexpr auto kAll = static_cast<int>(kLimits.connection.max_num_connections);
  Fixture fixture;
  const int other = fixture.Add(Phase::kIdle, 1000, "other");
  const int longest = fixture.Add(Phase::kWriting, 100, "greedy");
  for (int i = 1; i < kOfAddress; ++i) fixture.Add(Phase::kWriting, 1, "greedy");
  CHECK(fixture.table.MakeRoomFor("other"));
  CHECK(fixture.table.size() == kOfAddress + 1);
  CHECK(fixture.table.MakeRoomFor("greedy"));
  CHECK(fixture.table.size() == kOfAddress);
  CHECK(fixture.table.Find(longest) == nullptr);
  for (int i = kOfAddress; i < kAll; ++i) fixture.Add(Phase::kIdle, 1, std::to_string(i));
  CHECK(fixture.table.MakeRoomFor("newcomer"));
  CHECK(fixture.table.size() == kAll - 1);
  CHECK(fixture.table.Find(other) != nullptr);
}

TEST_CASE("connection table: pipelined requests are served last, and one at a time") {
  Fixture fixture;
  const int first = fixture.Add(Phase::kQueued, 100, "", true);
  fixture.Add(Phase::kQueued, 90, "", true);
  const int old = fixture.Add(Phase::kQueued, 10);
  const int young = fixture.Add(Phase::kQueued, 1);
  for (const int next : {old, young, first}) {
    ClientConnection* const found = fixture.table.NextToServe(10);
    REQUIRE(found == fixture.table.Find(next));
    found->phase = Phase::kServing;
  }
  CHECK(fixture.table.NextToServe(10) == nullptr);
  const int late = fixture.Add(Phase::kQueued, 0.0);
  CHECK(fixture.table.NextToServe(3) == nullptr);
  CHECK(fixture.table.NextToServe(4) == fixture.table.Find(late));
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
