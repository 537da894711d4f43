// Server-Sent Events.
#include <memory>

#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// What an event source hears, until it has heard `until` or ten seconds have passed.
std::string Listen(const TestServer& server,
                   const std::string& path,
                   const std::string& until,
                   const std::function<void()>& meanwhile,
                   const httplib::Headers& headers = {}) {
  httplib::Client client = server.Client();
  client.set_read_timeout(10);
  std::string heard;
  bool has_begun = false;
  client.Get(path, headers, [&](const char* bytes, size_t size) {
    heard.append(bytes, size);
    if (!has_begun) meanwhile();
    has_begun = true;
    return heard.find(until) == std::string::npos;
  });
  return heard;
}

std::string LastId(const std::string& heard) {
  const size_t at = heard.rfind("id: ");
  REQUIRE(at != std::string::npos);
  return heard.substr(at + 4, heard.find('\n', at) - at - 4);
}

TEST_CASE("events: frames, regions and jobs are told as they happen, of the flight asked for") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string other = NewFlight(fresh.client);
  const std::string heard =
      Listen(fresh.server, "/v1/events?flight=" + flight, "\"state\":\"done\"", [&] {
        PutFrame(fresh.client, other, "not-mine", NoiseImage(2), SomeMeta(2));
        PutFrame(fresh.client, flight, "mine", NoiseImage(1), SomeMeta(1));
        fresh.client.Post("/v1/flights/" + flight + "/finish");
      });
  INFO(heard);
  CHECK(heard.starts_with("retry: "));
  for (const char* text : {"event: frame\ndata: {\"id\":\"mine\"", "event: region", "event: job"}) {
    INFO(text);
    CHECK(heard.find(text) != std::string::npos);
  }
  CHECK(heard.find("not-mine") == std::string::npos);
}

TEST_CASE("events: who comes back with the last id gets what was missed, once") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto put = [&](int number) {
    PutFrame(
        fresh.client, flight, "n" + std::to_string(number), NoiseImage(number), SomeMeta(number));
  };
  const std::string first = Listen(fresh.server, "/v1/events", "\"id\":\"n1\"", [&] { put(1); });
  put(2);
  const std::string second = Listen(fresh.server,
                                    "/v1/events",
                                    "\"id\":\"n3\"",
                                    [&] { put(3); },
                                    {{"Last-Event-ID", LastId(first)}});
  INFO(second);
  CHECK(second.find("\"id\":\"n2\"") != std::string::npos);
  // Nothing that was heard comes again.
  CHECK(second.find("id: " + LastId(first) + "\n") == std::string::npos);
  CHECK(second.find("event: resync") == std::string::npos);
}

TEST_CASE("events: an id that is not known any more is answered with a resync") {
  FreshServer fresh;
  const std::string heard =
      Listen(fresh.server, "/v1/events", "resync", [] {}, {{"Last-Event-ID", "1234-5"}});
  CHECK(heard.find("event: resync") != std::string::npos);
  CheckProblem(fresh.client.Get("/v1/events?flight=none"), 404, "NoSuchFlight");
}

TEST_CASE("events: clients are bounded, and one that leaves makes room") {
  FreshServer fresh;
  std::vector<std::unique_ptr<RawConnection>> clients;
  for (int i = 0; i < kLimits.events.max_num_clients; ++i) {
    clients.push_back(std::make_unique<RawConnection>(fresh.server.port()));
    clients.back()->Send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    CHECK(clients.back()->ReceiveHead().find("200") != std::string::npos);
  }
  const auto result = fresh.client.Get("/v1/events");
  CheckProblem(result, 503, "Unavailable");
  CHECK(result->has_header("Retry-After"));
  clients.clear();
  const std::string flight = NewFlight(fresh.client);
  int status = 503;
  for (int i = 0; status == 503 && i < 100; ++i) {
    // What happens shows the server that they are gone.
    PutFrame(fresh.client, flight, "n" + std::to_string(i), NoiseImage(1), SomeMeta(i));
    RawConnection again(fresh.server.port());
    again.Send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    status = again.ReceiveHead().find(" 200 ") != std::string::npos ? 200 : 503;
  }
  CHECK(status == 200);
}

TEST_CASE(
    "events: 40 readers hold no threads while requests go on, and each reader hears what happens") {
  constexpr int kNumReaders = 40;
  FreshServer fresh([](Config& config) { config.num_http_threads = 4; });
  const std::string flight = NewFlight(fresh.client);
  std::vector<std::unique_ptr<RawConnection>> readers;
  for (int i = 0; i < kNumReaders; ++i) {
    readers.push_back(std::make_unique<RawConnection>(fresh.server.port()));
    readers.back()->Send("GET /v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  for (const auto& reader : readers) {
    CHECK(reader->ReceiveUntil("retry: ").starts_with("HTTP/1.1 200"));
  }
  for (int i = 0; i < 10; ++i) {
    const std::string frame = "n" + std::to_string(i);
    CHECK(PutFrame(fresh.client, flight, frame, NoiseImage(i), SomeMeta(i))->status == 201);
  }
  for (const auto& reader : readers) {
    CHECK_FALSE(reader->ReceiveUntil("\"id\":\"n9\"").empty());
  }
}

}  // namespace
}  // namespace freelsd
