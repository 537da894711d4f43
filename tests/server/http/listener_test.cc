// The listener that must not fall: slow, idle and greedy clients do not keep others from answers.
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "server/descriptors.h"
#include "tests/server/recall/emergency_query.h"

namespace freelsd {
namespace {

// A hundred times what an answer takes; a machine may be busy.
constexpr std::chrono::milliseconds kPatience{500};

using Connections = std::vector<std::unique_ptr<RawConnection>>;

std::string HeadOf(const std::string& method, const std::string& path, const std::string& more) {
  return method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n";
}

// That many connections, each of which sends `begin`.
Connections Open(int port, int count, const std::string& begin) {
  Connections connections;
  for (int i = 0; i < count; ++i) {
    connections.push_back(std::make_unique<RawConnection>(port));
    connections.back()->Send(begin);
  }
  return connections;
}

// The longest of `count` GET requests, each over a connection of its own.
std::chrono::milliseconds LongestGet(int port, const std::string& path, int count) {
  std::chrono::milliseconds longest{0};
  for (int i = 0; i < count; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    RawConnection connection(port);
    connection.Send(HeadOf("GET", path, ""));
    CHECK(connection.Receive().starts_with("HTTP/1.1 200"));
    longest = std::max(longest,
                       std::chrono::duration_cast<std::chrono::milliseconds>(
                           std::chrono::steady_clock::now() - begin));
  }
  return longest;
}

void WithEmergencyListener(Config& config) { config.emergency = Address{"127.0.0.1", 0}; }

void PostNoiseBatch(httplib::Client& client, int num_images) {
  const std::string flight = NewFlight(client);
  httplib::MultipartFormDataItems items;
  std::string poses = "image,latitude_deg,longitude_deg,altitude_m\n";
  for (int i = 0; i < num_images; ++i) {
    const std::string name = std::to_string(i) + ".jpg";
    items.push_back({"images", NoiseImage(i), name, "image/jpeg"});
    poses += name + ",47.00" + std::to_string(100 + i) + ",8.0,500\n";
  }
  items.push_back({"poses", poses, "poses.csv", "text/csv"});
  REQUIRE(client.Post("/v1/flights/" + flight + "/batch", items)->status == 202);
}

TEST_CASE(
    "listener: 100 slow bodies, 100 slow heads, 100 idle and a batch keep no recall from its "
    "answer") {
  constexpr int kNumSlow = 100;
  constexpr int kNumRecalls = 20;
  MeadowServer meadow(StoreAmslMeadow, WithEmergencyListener);
  const int port = meadow.server->emergency_port();
  httplib::Client calm = meadow.server->EmergencyClient();
  // Plans once, so that what follows measures the listener.
  REQUIRE(WholeAnswer(calm, Query(600, kCalmNorth))["sites"].size() == 1);
  PostNoiseBatch(*meadow.client, 12);
  const Connections idle = Open(port, kNumSlow, "");
  const Connections heads = Open(port, kNumSlow, "GET /v1/emergency HTTP/1.1\r\nHost: loc");
  const Connections bodies =
      Open(port, kNumSlow, HeadOf("POST", "/v1/emergency", "Content-Length: 1000\r\n") + "{");
  CHECK(LongestGet(port, Query(600, kCalmNorth), kNumRecalls) < kPatience);
}

TEST_CASE("listener: a slow head and a slow small body are refused after a second") {
  constexpr std::chrono::seconds kMaxWait{3};
  MeadowServer meadow({}, WithEmergencyListener);
  for (const int port : {meadow.server->port(), meadow.server->emergency_port()}) {
    RawConnection head(port);
    RawConnection body(port);
    const auto begin = std::chrono::steady_clock::now();
    head.Send("GET /healthz HTTP/1.1\r\nHost:");
    body.Send(HeadOf("POST", "/v1/emergency", "Content-Length: 1000\r\n") + "{");
    for (RawConnection* const slow : {&head, &body}) {
      const std::string answer = slow->Receive();
      CHECK(answer.starts_with("HTTP/1.1 408"));
      CHECK(answer.find("RequestTimeout") != std::string::npos);
    }
    CHECK(std::chrono::steady_clock::now() - begin < kMaxWait);
  }
}

TEST_CASE("listener: the emergency listener takes small bodies in any form, and no large one") {
  MeadowServer meadow(StoreAmslMeadow, WithEmergencyListener);
  const int port = meadow.server->emergency_port();
  const std::string small =
      R"({"latitude_deg":46.9955,"longitude_deg":8,"altitude_m":600,"altitude_datum":"amsl"})";
  char size[8];
  std::snprintf(size, sizeof(size), "%zx", small.size());
  const std::string whole = HeadOf("POST", "/v1/emergency", "Transfer-Encoding: chunked\r\n") +
                            size + "\r\n" + small + "\r\n0\r\n\r\n";
  RawConnection chunked(port);
  // Twice over one connection; the second arrives byte by byte.
  chunked.Send(whole);
  CHECK(chunked.Receive().starts_with("HTTP/1.1 200"));
  for (const char byte : whole) chunked.Send(std::string(1, byte));
  CHECK(chunked.Receive().starts_with("HTTP/1.1 200"));
  RawConnection large(port);
  large.Send(HeadOf("POST", "/v1/emergency", "Content-Length: 100000\r\n"));
  CHECK(large.Receive().starts_with("HTTP/1.1 413"));
  RawConnection endless(port);
  endless.Send(HeadOf("POST", "/v1/emergency", "Transfer-Encoding: chunked\r\n") + "20000\r\n" +
               std::string(0x20000, ' '));
  CHECK(endless.Receive().starts_with("HTTP/1.1 413"));
}

TEST_CASE("listener: large bodies that arrive slowly leave all others their threads") {
  const FreshServer fresh;
  const int port = fresh.server.port();
  const int num_taken = kLimits.connection.max_num_large_bodies;
  const Connections taken = Open(
      port, num_taken, HeadOf("POST", "/v1/flights", "Transfer-Encoding: chunked\r\n") + "9\r\n{");
  // Until all of them are being read.
  CHECK(LongestGet(port, "/healthz", 20) < kPatience);
  RawConnection beyond(port);
  beyond.Send(HeadOf("POST", "/v1/flights", "Content-Length: 500000\r\n"));
  const std::string answer = beyond.Receive();
  CHECK(answer.starts_with("HTTP/1.1 429"));
  CHECK(answer.find("Retry-After: ") != std::string::npos);
  RawConnection small(port);
  small.Send(HeadOf("POST", "/v1/flights", "Content-Length: 12\r\n") + R"({"name":"x"})");
  CHECK(small.Receive().starts_with("HTTP/1.1 201"));
}

TEST_CASE("listener: clients that do not read their answers hold no threads") {
  constexpr int kNumReaders = 40;
  constexpr int kNumAnswers = 100;
  const FreshServer fresh;
  const int port = fresh.server.port();
  std::string requests;
  for (int i = 0; i < kNumAnswers; ++i) requests += HeadOf("GET", "/openapi.json", "");
  // Far more than the kernel holds for them.
  const Connections readers = Open(port, kNumReaders, requests);
  std::this_thread::sleep_for(kPatience);
  CHECK(LongestGet(port, "/healthz", 10) < kPatience);
  // Who reads at last gets every answer.
  for (int i = 0; i < kNumAnswers; ++i) {
    REQUIRE(readers[0]->Receive().starts_with("HTTP/1.1 200"));
  }
}

TEST_CASE(
    "listener: 1100 connections that pipeline and read slowly keep no recall from its answer") {
  constexpr int kNumGreedy = 1100;
  constexpr int kNumRequests = 50;
  RaiseDescriptorLimit();
  MeadowServer meadow(StoreAmslMeadow, WithEmergencyListener);
  const int port = meadow.server->emergency_port();
  httplib::Client calm = meadow.server->EmergencyClient();
  REQUIRE(WholeAnswer(calm, Query(600, kCalmNorth))["sites"].size() == 1);
  std::string requests;
  for (int i = 0; i < kNumRequests; ++i) requests += HeadOf("GET", Query(600, kCalmNorth), "");
  const Connections greedy = Open(port, kNumGreedy, requests);
  CHECK(LongestGet(port, Query(600, kCalmNorth), 20) < kPatience);
  // Those that are not closed are served too.
  CHECK(greedy.back()->Receive().starts_with("HTTP/1.1 200"));
}

TEST_CASE("listener: 100 kept connections are served in turn, also two requests at once") {
  MeadowServer meadow({}, WithEmergencyListener);
  const std::string request = HeadOf("GET", "/healthz", "");
  const Connections kept = Open(meadow.server->emergency_port(), 100, request + request);
  for (int i = 0; i < 2; ++i) {
    for (const auto& connection : kept) {
      CHECK(connection->Receive().starts_with("HTTP/1.1 200"));
    }
  }
  for (const auto& connection : kept) connection->Send(request);
  for (const auto& connection : kept) {
    CHECK(connection->Receive().starts_with("HTTP/1.1 200"));
  }
}

TEST_CASE("listener: a server with clients of every kind stops within seconds") {
  constexpr std::chrono::seconds kMaxStop{4};
  auto fresh = std::make_unique<FreshServer>(WithEmergencyListener);
  const int port = fresh->server.port();
  const Connections idle = Open(port, 20, "");
  const Connections heads = Open(port, 20, "GET / HT");
  const Connections live = Open(port, 20, HeadOf("GET", "/v1/events", ""));
  const Connections large =
      Open(port, 4, HeadOf("POST", "/v1/flights", "Transfer-Encoding: chunked\r\n") + "9\r\n{");
  CHECK(live.back()->ReceiveUntil("retry").starts_with("HTTP/1.1 200"));
  const auto begin = std::chrono::steady_clock::now();
  fresh.reset();
  CHECK(std::chrono::steady_clock::now() - begin < kMaxStop);
}

}  // namespace
}  // namespace freelsd
