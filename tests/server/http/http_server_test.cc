// What clients and the network do to an HTTP server.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/http/http.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

std::string HeadOf(const std::string& method, const std::string& path, const std::string& more) {
  return method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n";
}

TEST_CASE("http: calls on a kept connection take less than 10 ms in the median") {
  constexpr int kNumCalls = 60;
  constexpr double kMaxMedianMs = 10.0;
  const FreshServer fresh;
  RawConnection connection(fresh.server.port());
  std::vector<double> durations_ms;
  for (int i = 0; i < kNumCalls; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    connection.Send(HeadOf("GET", "/v1/flights", ""));
    // Far beyond the library's default of 5 requests: an answer each time on one connection.
    REQUIRE(connection.Receive().starts_with("HTTP/1.1 200"));
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - begin;
    durations_ms.push_back(elapsed.count());
  }
  std::sort(durations_ms.begin(), durations_ms.end());
  CHECK(durations_ms[kNumCalls / 2] < kMaxMedianMs);
}

TEST_CASE("http: a problem drops the tag of the answer that could not be given") {
  httplib::Response response;
  response.set_header("ETag", "\"1\"");
  response.set_header("Cache-Control", "private, no-cache");
  AnswerProblem(ApiError("Unavailable", "files of other maps are being written"), response);
  CHECK(response.status == 503);
  CHECK_FALSE(response.has_header("ETag"));
  CHECK(response.get_header_value_count("Cache-Control") == 1);
  CHECK(response.get_header_value("Cache-Control") == "no-store");
  CHECK(response.has_header("Retry-After"));
}

TEST_CASE("http: a serving thread can learn that its client has left") {
  int ends[2] = {-1, -1};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0);
  const ClientSocket socket(ends[0]);
  CHECK_FALSE(socket.HasEnded());
  REQUIRE(::write(ends[1], "a", 1) == 1);
  CHECK_FALSE(socket.HasEnded());
  ::close(ends[1]);
  char byte = 0;
  // What it sent before is still there.
  CHECK(socket.HasEnded());
  CHECK(socket.HasBytes());
  CHECK(socket.ReadNow(&byte, 1) == 1);
  CHECK(byte == 'a');
  CHECK(socket.HasEnded());
}

TEST_CASE("http: a POST without body and length is answered at once") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  RawConnection connection(fresh.server.port());
  const auto begin = std::chrono::steady_clock::now();
  connection.Send(HeadOf("POST", "/v1/flights/" + flight + "/finish", ""));
  CHECK(connection.Receive().starts_with("HTTP/1.1 202"));
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(1));
}

TEST_CASE("http: a chunked body over the limit is refused with 413 before it ends") {
  FreshServer fresh;
  RawConnection connection(fresh.server.port());
  connection.Send(HeadOf("POST", "/v1/flights", "Transfer-Encoding: chunked\r\n"));
  const std::string chunk = "40000\r\n" + std::string(0x40000, ' ') + "\r\n";
  for (int i = 0; i < 6; ++i) connection.Send(chunk);
  const std::string answer = connection.Receive();
  CHECK(answer.starts_with("HTTP/1.1 413"));
  CHECK(answer.find("BodyTooLarge") != std::string::npos);
  CHECK(answer.find("\"limit\":1048576") != std::string::npos);
}

TEST_CASE("http: a small chunked body is taken, and the connection kept") {
  FreshServer fresh;
  RawConnection connection(fresh.server.port());
  connection.Send(HeadOf("POST", "/v1/flights", "Transfer-Encoding: chunked\r\n") +
                  "9\r\n{\"name\": \r\n5\r\n\"a b\"\r\n1\r\n}\r\n0\r\n\r\n");
  CHECK(connection.Receive().starts_with("HTTP/1.1 201"));
  connection.Send(HeadOf("GET", "/healthz", ""));
  CHECK(connection.Receive().starts_with("HTTP/1.1 200"));
}

TEST_CASE("http: a declared length over the limit is refused without reading the body") {
  FreshServer fresh;
  RawConnection connection(fresh.server.port());
  connection.Send(HeadOf("POST", "/v1/flights", "Content-Length: 900000000\r\n"));
  CHECK(connection.Receive().starts_with("HTTP/1.1 413"));
}

TEST_CASE("http: a client that waits for 100 Continue gets it") {
  FreshServer fresh;
  RawConnection connection(fresh.server.port());
  const std::string body = R"({"name":"x"})";
  connection.Send(
      HeadOf("POST",
             "/v1/flights",
             "Expect: 100-continue\r\nContent-Length: " + std::to_string(body.size()) + "\r\n"));
  CHECK(connection.Receive().starts_with("HTTP/1.1 100"));
  connection.Send(body);
  CHECK(connection.Receive().starts_with("HTTP/1.1 201"));
}

TEST_CASE("http: an exception's text reaches no client") {
  HttpServer server({}, [](const httplib::Request&, BodyReader&, httplib::Response&) {
    throw std::runtime_error("/secret/path");
  });
  const int port = server.Bind("127.0.0.1", 0);
  std::thread thread([&server] { server.Run(); });
  std::string answer;
  {
    RawConnection connection(port);
    connection.Send(HeadOf("GET", "/", ""));
    answer = connection.Receive();
  }
  server.Stop();
  thread.join();
  CHECK(answer.starts_with("HTTP/1.1 500"));
  CHECK(answer.find("application/problem+json") != std::string::npos);
  CHECK(answer.find("secret") == std::string::npos);
  CHECK(answer.find("EXCEPTION_WHAT") == std::string::npos);
}

TEST_CASE("http: a live answer that its client does not read ends, and frees what it holds") {
  constexpr std::chrono::seconds kPatience{30};
  const auto held = std::make_shared<int>(0);
  HttpServer server({}, [&held](const httplib::Request&, BodyReader&, httplib::Response& response) {
    AnswerLive(response,
               "text/plain",
               "begin",
               {[copy = held] {
                  return LiveText{std::string(100000, 'x'), false};
                },
                "still here"});
  });
  const int port = server.Bind("127.0.0.1", 0);
  std::thread thread([&server] { server.Run(); });
  RawConnection connection(port);
  connection.Send(HeadOf("GET", "/", ""));
  CHECK(connection.ReceiveHead().starts_with("HTTP/1.1 200"));
  CHECK(held.use_count() > 1);
  const auto begin = std::chrono::steady_clock::now();
  while (held.use_count() > 1 && std::chrono::steady_clock::now() - begin < kPatience) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  CHECK(held.use_count() == 1);
  server.Stop();
  thread.join();
}

TEST_CASE("http: a second server on a taken port says so instead of sharing the traffic") {
  const FreshServer fresh;
  const TemporaryFolder folder;
  Config config = TestConfig(folder.path());
  config.port = fresh.server.port();
  CHECK_THROWS_WITH_AS(App{config}, doctest::Contains("the port is taken"), std::runtime_error);
}

TEST_CASE("http: a second server on a data folder in use says so") {
  const FreshServer fresh;
  CHECK_THROWS_WITH_AS(App{TestConfig(fresh.folder.path() / "data")},
                       doctest::Contains("another freelsd-server uses this folder"),
                       StorageError);
}

TEST_CASE("http: what is not there, not taken or not known is a problem with its status") {
  FreshServer fresh;
  CheckProblem(fresh.client.Get("/v2/nothing"), 404, "NotFound");
  CheckProblem(fresh.client.Get("/v1/flights/none"), 404, "NoSuchFlight");
  CheckProblem(fresh.client.Get("/v1/jobs/none"), 404, "NoSuchJob");
  CheckProblem(fresh.client.Get("/v1/sites/none"), 404, "NoSuchSite");
  CheckProblem(fresh.client.Get("/v1/sites?colour=green"), 400, "UnknownParameter");
  CheckProblem(fresh.client.Get("/v1/sites?limit=many"), 400, "InvalidQuery");
  CheckProblem(fresh.client.Get("/v1/sites?bbox=1,2,3"), 400, "InvalidQuery");
  CheckProblem(fresh.client.Get("/v1/sites?bbox=1,2,3,nan"), 400, "InvalidQuery");
  CheckProblem(fresh.client.Post("/v1/flights", "{", "application/json"), 400, "InvalidJson");
  CheckProblem(
      fresh.client.Post("/v1/flights", R"({"nam":"x"})", "application/json"), 422, "UnknownKey");
}

TEST_CASE("http: JSON with bytes after its end is refused, also if they are NUL") {
  FreshServer fresh;
  for (const std::string& rest :
       {std::string(1, '\0'), std::string(3, '\0'), std::string("\0 x", 3)}) {
    const std::string flight = R"({"name":"x"})" + rest;
    CheckProblem(fresh.client.Post("/v1/flights", flight, "application/json"), 400, "InvalidJson");
    const std::string recall = R"({"latitude_deg":47,"longitude_deg":8,"altitude_m":500})" + rest;
    CheckProblem(
        fresh.client.Post("/v1/emergency", recall, "application/json"), 400, "InvalidJson");
  }
}

TEST_CASE("http: DELETE on a path that only reads is 405 and says what it takes") {
  FreshServer fresh;
  const auto result = fresh.client.Delete("/v1/flights");
  CheckProblem(result, 405, "MethodNotAllowed");
  CHECK(result->get_header_value("Allow").find("GET") != std::string::npos);
  CHECK(result->get_header_value("Allow").find("DELETE") == std::string::npos);
  CheckProblem(fresh.client.Delete("/healthz"), 405, "MethodNotAllowed");
  CheckProblem(fresh.client.Delete("/v1/info"), 405, "MethodNotAllowed");
}

TEST_CASE(
    "http: what another site's page makes the browser ask is refused, but a link to the page") {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "index.html") << "the page";
  FreshServer fresh([&folder](Config& config) { config.page = folder.path(); });
  const auto status_of = [&fresh](const char* path, const char* site, const char* destination) {
    const httplib::Headers headers{
        {"Sec-Fetch-Site", site},
        {"Sec-Fetch-Mode", destination == std::string("image") ? "no-cors" : "navigate"},
        {"Sec-Fetch-Dest", destination}};
    return fresh.client.Get(path, headers)->status;
  };
  constexpr char kReach[] = "/v1/reach?latitude_deg=47&longitude_deg=8&altitude_m=500";
  CHECK(status_of(kReach, "cross-site", "image") == 403);
  CHECK(status_of(kReach, "cross-site", "document") == 403);
  CHECK(status_of("/healthz", "cross-site", "image") == 403);
  CHECK(status_of("/", "cross-site", "iframe") == 403);
  CHECK(status_of("/", "cross-site", "document") == 200);
  for (const char* const site : {"same-origin", "none"}) {
    CHECK(status_of(kReach, site, "document") == 200);
    CHECK(status_of("/", site, "document") == 200);
  }
  CheckProblem(
      fresh.client.Get(kReach, {{"Sec-Fetch-Site", "cross-site"}}), 403, "ForbiddenOrigin");
}

TEST_CASE("http: malformed requests are problems too, and end the connection") {
  struct Case {
    const char* text;
    const char* status;
  };
  const FreshServer fresh;
  const std::string long_path(3000, 'x');
  const std::string many_headers = [] {
    std::string text;
    for (int i = 0; i < 100; ++i) text += "X-" + std::to_string(i) + ": 1\r\n";
    return text;
  }();
  const std::vector<std::pair<std::string, std::string>> cases{
      {"nonsense\r\n\r\n", "400"},
      {"GET / HTTP/1.1\r\n\r\n", "400"},
      {"BREW / HTTP/1.1\r\nHost: localhost\r\n\r\n", "405"},
      {HeadOf("GET", "/" + long_path, ""), "414"},
      {HeadOf("GET", "/", many_headers), "431"},
      {HeadOf("GET", "/", "X: " + std::string(20000, 'x') + "\r\n"), "431"},
      {HeadOf("POST", "/v1/flights", "Content-Length: 2\r\nContent-Length: 3\r\n"), "400"},
      {HeadOf("POST", "/v1/flights", "Content-Length: -1\r\n"), "400"},
      {HeadOf("POST", "/v1/flights", "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n"), "400"},
      {HeadOf("POST", "/v1/flights", "Transfer-Encoding: chunked\r\n") + "-2\r\n", "400"},
      {HeadOf("GET", "/", "X-T: a%0d%0aInjected: 1\r\n"), "400"},
      {"GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: 127.0.0.1:8831@evil.com\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost:80:80\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: [::1]evil.com:80\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost:80/x\r\n\r\n", "403"},
      {HeadOf("GET", "/v1/flights", "Origin: http://evil.example\r\n"), "403"},
      {HeadOf("GET", "/v1/flights", "Content-Length: 5\r\n") + "hello", "400"},
      {HeadOf("POST", "/v1/flights", "Content-Length: 2\r\nContent-Encoding: gzip\r\n") + "{}",
       "415"},
  };
  for (const auto& [request, status] : cases) {
    const std::string start = request.substr(0, 80);
    INFO(start);
    RawConnection connection(fresh.server.port());
    connection.Send(request);
    const std::string answer = connection.Receive();
    CHECK(answer.starts_with("HTTP/1.1 " + status));
    CHECK(answer.find("application/problem+json") != std::string::npos);
  }
}

TEST_CASE("http: health, readiness, settings and the contract are served") {
  FreshServer fresh;
  CHECK(GetJson(fresh.client, "/readyz")["ready"] == true);
  const nlohmann::json info = GetJson(fresh.client, "/v1/info");
  CHECK(info["limits"]["max_image_megapixels"] == 64.0);
  CHECK(info["aircraft_profiles"].contains("techpod"));
  CHECK(GetJson(fresh.client, "/openapi.json").contains("openapi"));
  CHECK(fresh.client.Head("/healthz")->status == 200);
  CHECK(GetJson(fresh.client, "/v1/flights")["flights"].empty());
  CHECK(GetJson(fresh.client, "/v1/sites")["features"].empty());
}

TEST_CASE("http: the page is served from memory and nothing beside it") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "page/vendor");
  std::ofstream(folder.path() / "page/index.html") << "<html>the page</html>";
  std::ofstream(folder.path() / "page/vendor/map.js") << "export {};";
  std::ofstream(folder.path() / "page/docs.html") << "<html>the interface</html>";
  std::ofstream(folder.path() / "secret.txt") << "secret";
  FreshServer fresh([&folder](Config& config) { config.page = folder.path() / "page"; });
  CHECK(fresh.client.Get("/")->body == "<html>the page</html>");
  for (const char* path : {"/docs", "/docs.html"}) {
    const auto docs = fresh.client.Get(path);
    CHECK(docs->body == "<html>the interface</html>");
    CHECK(docs->get_header_value("Content-Type") == "text/html; charset=utf-8");
  }
  CHECK(fresh.client.Get("/vendor/map.js")->get_header_value("Content-Type") ==
        "text/javascript; charset=utf-8");
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/vendor/..%2f../secret.txt"}) {
    CHECK(fresh.client.Get(path)->status == 404);
  }
  CheckProblem(fresh.client.Delete("/"), 405, "MethodNotAllowed");
}

}  // namespace
}  // namespace freelsd
