// Tokens, their scopes, and what is counted.
#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "api/import/import.h"
#include "tests/server/child.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// Reader, sender and master, by the SHA-256 of their tokens.
std::filesystem::path TokenFile(const std::filesystem::path& folder) {
  const nlohmann::json tokens{
      {{"sha256", Sha256Hex("reader")}, {"scopes", {"read"}}},
      {{"sha256", Sha256Hex("sender")}, {"scopes", {"read", "ingest"}}},
      {{"sha256", Sha256Hex("master")}, {"scopes", {"read", "ingest", "admin"}}}};
  std::filesystem::path file = folder / "tokens.json";
  std::ofstream(file) << tokens.dump();
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  return file;
}

struct GuardedServer {
  TemporaryFolder folder;
  TestServer server;
  httplib::Client client;

  GuardedServer() : server(Guarded(folder.path())), client(server.Client()) {}
  static Config Guarded(const std::filesystem::path& folder) {
    Config config = TestConfig(folder / "data");
    config.token_file = TokenFile(folder);
    return config;
  }
};

httplib::Headers As(const std::string& token) { return {{"Authorization", "Bearer " + token}}; }

TEST_CASE("tokens: without a known one everything but health is 401") {
  GuardedServer guarded;
  httplib::Client& client = guarded.client;
  CHECK(client.Get("/healthz")->status == 200);
  const auto result = client.Get("/v1/flights");
  CheckProblem(result, 401, "Unauthorized");
  CHECK(result->get_header_value("WWW-Authenticate") == "Bearer");
  CheckProblem(client.Get("/v1/flights", As("wrong")), 401, "Unauthorized");
  CheckProblem(client.Get("/v1/flights", As("")), 401, "Unauthorized");
  CheckProblem(client.Get("/v1/flights", As(Sha256Hex("reader"))), 401, "Unauthorized");
  CheckProblem(
      client.Get("/v1/flights", {{"Authorization", "Basic cmVhZGVy"}}), 401, "Unauthorized");
  CheckProblem(client.Get("/v1/flights?token=reader"), 401, "Unauthorized");
  CheckProblem(client.Get("/metrics"), 401, "Unauthorized");
  CheckProblem(client.Post("/v1/flights", R"({"name":"x"})", ""), 401, "Unauthorized");
}

TEST_CASE("tokens: each may do what its scopes allow and nothing else") {
  GuardedServer guarded;
  httplib::Client& client = guarded.client;
  CHECK(client.Get("/v1/flights", As("reader"))->status == 200);
  const std::string body = R"({"name":"x"})";
  CheckProblem(client.Post("/v1/flights", As("reader"), body, ""), 403, "Forbidden");
  const auto made = client.Post("/v1/flights", As("sender"), body, "");
  REQUIRE(made->status == 201);
  const std::string path =
      "/v1/flights/" + nlohmann::json::parse(made->body)["id"].get<std::string>();
  CheckProblem(client.Delete(path, As("sender")), 403, "Forbidden");
  CHECK(client.Delete(path, As("master"))->status == 204);
  // Asking what can be reached is reading, whatever the method.
  CHECK(client
            .Post("/v1/emergency",
                  As("reader"),
                  R"({"latitude_deg":47,"longitude_deg":8,"altitude_m":500})",
                  "")
            ->status == 200);
}

TEST_CASE("tokens: beyond loopback the program serves with a token file, and only then") {
  const TemporaryFolder folder;
  ChildOptions options{folder.path(), TestModel(), "0.0.0.0:0"};
  options.more_arguments = {"--token-file", TokenFile(folder.path())};
  Child child(options);
  httplib::Client client = ClientOf(child.AwaitPort("listens on http://0.0.0.0:"));
  CHECK(client.Get("/healthz")->status == 200);
  CheckProblem(client.Get("/v1/flights"), 401, "Unauthorized");
  CHECK(client.Get("/v1/flights", As("reader"))->status == 200);
  CHECK(child.Output().find("reader") == std::string::npos);
}

TEST_CASE("tokens: a file that others may read, or that is none, ends the start with a sentence") {
  const TemporaryFolder folder;
  const std::filesystem::path file = TokenFile(folder.path());
  CHECK_NOTHROW(TokenList::Read(file));
  std::filesystem::permissions(file, std::filesystem::perms(0644));
  CHECK_THROWS_WITH_AS(TokenList::Read(file), doctest::Contains("0600"), ConfigError);
  std::filesystem::permissions(file, std::filesystem::perms(0600));
  for (const char* text : {"{", "[]", "{}", "[1]", R"([{"sha256":"xyz","scopes":[]}])"}) {
    std::ofstream(file) << text;
    CHECK_THROWS_AS(TokenList::Read(file), ConfigError);
  }
  // Whoever limited a token in another way must not find that it sees all.
  std::ofstream(file) << R"([{"sha256":")" << std::string(64, 'a')
                      << R"(","scopes":["read"],"organisation":"north"}])";
  CHECK_THROWS_WITH_AS(TokenList::Read(file), doctest::Contains("organisation"), ConfigError);
  CHECK_THROWS_AS(TokenList::Read(folder.path() / "none"), ConfigError);
}

TEST_CASE("metrics: requests are counted by route and status, never by what a client sent") {
  FreshServer fresh;
  fresh.client.Get("/v1/flights/none");
  fresh.client.Get("/no/such/path");
  const auto metrics = fresh.client.Get("/metrics");
  REQUIRE(metrics);
  CHECK(metrics->status == 200);
  CHECK(metrics->get_header_value("Content-Type") == "text/plain; version=0.0.4");
  CHECK(metrics->body.find(R"(route="/v1/flights/{flight}",status="404"} 1)") != std::string::npos);
  CHECK(metrics->body.find("such/path") == std::string::npos);
  CHECK(metrics->body.find("freelsd_queued_frames 0") != std::string::npos);
  CHECK(metrics->body.find("freelsd_writable ") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
