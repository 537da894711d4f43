#include "server/config.h"

#include <fstream>

#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

std::optional<Config> Read(const std::vector<const char*>& arguments) {
  std::vector<const char*> all{"freelsd-server"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return ReadConfig(static_cast<int>(all.size()), all.data());
}

TEST_CASE("config: data and address suffice") {
  const auto config = Read({"--data", "/tmp/x", "--listen", "127.0.0.1:9000"});
  REQUIRE(config);
  CHECK(config->data == "/tmp/x");
  CHECK(config->port == 9000);
}

TEST_CASE("config: a PostgreSQL database needs a folder of images, and SQLite has its own") {
  const auto config =
      Read({"--data", "/tmp/x", "--database", "postgresql://a/b", "--images", "/i"});
  REQUIRE(config);
  CHECK(config->database == "postgresql://a/b");
  CHECK(config->images == "/i");
  CHECK_THROWS_WITH_AS(Read({"--data", "/tmp/x", "--database", "postgresql://a/b"}),
                       doctest::Contains("--images"),
                       ConfigError);
  CHECK_THROWS_WITH_AS(
      Read({"--data", "/tmp/x", "--images", "/i"}), doctest::Contains("--database"), ConfigError);
  CHECK_THROWS_WITH_AS(Read({"--data", "/tmp/x", "--database", "mysql://a/b", "--images", "/i"}),
                       doctest::Contains("postgresql://"),
                       ConfigError);
}

TEST_CASE("config: the command line wins over the file") {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "config.json";
  std::ofstream(file) << R"({"data": "/tmp/y", "listen": "[::1]:1", "allowed_hosts": ["base"]})";
  const auto config = Read({"--config", file.c_str(), "--data", "/tmp/x"});
  REQUIRE(config);
  CHECK(config->data == "/tmp/x");
  CHECK(config->host == "::1");
  CHECK(config->allowed_hosts == std::vector<std::string>{"base"});
}

TEST_CASE("config: there is no base map unless the file names one") {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "config.json";
  std::ofstream(file) << R"({"data": "/tmp/y"})";
  CHECK(Read({"--config", file.c_str()})->base_map_url.empty());
  CHECK(Read({"--config", file.c_str()})->base_map_file.empty());
  std::ofstream(file) << R"({"data": "/tmp/y", "base_map_url": "https://a.org/{z}/{x}/{y}",
      "base_map_file": "/map", "base_map_attribution": "us", "base_map_max_zoom": 12})";
  const auto config = Read({"--config", file.c_str()});
  CHECK(config->base_map_url == "https://a.org/{z}/{x}/{y}");
  CHECK(config->base_map_file == "/map");
  CHECK(config->base_map_attribution == "us");
  CHECK(config->base_map_max_zoom == 12);
  std::ofstream(file) << R"({"data": "/tmp/y", "base_map_max_zoom": "far"})";
  CHECK_THROWS_WITH_AS(
      Read({"--config", file.c_str()}), doctest::Contains("base_map_max_zoom"), ConfigError);
}

TEST_CASE("config: a server follows another one over an area, on SQLite") {
  const auto config = Read({"--data", "/x", "--follow", "https://centre", "--area", "7,46,9,48"});
  CHECK(config->follow == "https://centre");
  CHECK(config->area == "7,46,9,48");
  CHECK_THROWS_WITH_AS(Read({"--data", "/x", "--follow", "https://centre"}),
                       doctest::Contains("--follow needs --area"),
                       ConfigError);
  CHECK_THROWS_WITH_AS(Read({"--data", "/x", "--area", "7,46,9,48"}),
                       doctest::Contains("need --follow"),
                       ConfigError);
  CHECK_THROWS_WITH_AS(Read({"--data", "/x", "--follow", "centre", "--area", "7,46,9,48"}),
                       doctest::Contains("must be https://"),
                       ConfigError);
  for (const char* const url : {"http://centre", "http://127.evil.example", "http://[::2]:80/x"}) {
    CHECK_THROWS_WITH_AS(
        Read({"--data", "/x", "--follow", url, "--area", "7,46,9,48", "--follow-token-file", "/t"}),
        doctest::Contains("over https:// only"),
        ConfigError);
  }
  for (const char* const url : {"https://centre", "http://127.0.0.1:80", "http://[::1]:80/x"}) {
    CHECK(Read(
        {"--data", "/x", "--follow", url, "--area", "7,46,9,48", "--follow-token-file", "/t"}));
  }
  CHECK_THROWS_WITH_AS(Read({"--data",
                             "/x",
                             "--database",
                             "postgresql://a/b",
                             "--images",
                             "/i",
                             "--follow",
                             "https://centre",
                             "--area",
                             "7,46,9,48"}),
                       doctest::Contains("only a server on SQLite"),
                       ConfigError);
}

TEST_CASE("config: a role is for a PostgreSQL database, by command line or by file") {
  const auto read = [](const char* role) {
    return Read(
        {"--data", "/x", "--database", "postgresql://a/b", "--images", "/i", "--role", role});
  };
  CHECK(read("api")->role == Role::kApi);
  CHECK(read("worker")->role == Role::kWorker);
  CHECK(read("all")->role == Role::kAll);
  CHECK_FALSE(Read({"--data", "/tmp/x"})->role);
  CHECK_THROWS_WITH_AS(read("boss"), doctest::Contains("api, worker and all"), ConfigError);
  CHECK_THROWS_WITH_AS(Read({"--data", "/tmp/x", "--role", "all"}),
                       doctest::Contains("--role needs --database"),
                       ConfigError);
  const TemporaryFolder folder;
  const std::string file = folder.path() / "config.json";
  std::ofstream(file)
      << R"({"data": "/x", "database": "postgresql://a/b", "images": "/i", "role": "worker"})";
  CHECK(Read({"--config", file.c_str()})->role == Role::kWorker);
}

TEST_CASE("config: an address that is not loopback is refused without a token") {
  for (const char* listen : {"0.0.0.0:80", "[::]:80", "192.168.1.2:80"}) {
    CHECK_THROWS_WITH_AS(
        Read({"--data", "/tmp/x", "--listen", listen}), doctest::Contains("loopback"), ConfigError);
  }
}

TEST_CASE("config: wrong settings are named") {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "config.json";
  std::ofstream(file) << R"({"dat": "/tmp/y"})";
  CHECK_THROWS_WITH_AS(Read({"--config", file.c_str()}), doctest::Contains("dat"), ConfigError);
  CHECK_THROWS_WITH_AS(Read({}), doctest::Contains("--data"), ConfigError);
  CHECK_THROWS_AS(Read({"--data", "/tmp/x", "--listen", "127.0.0.1:99999"}), ConfigError);
  CHECK_THROWS_AS(Read({"--data", "/tmp/x", "--listen", "8080"}), ConfigError);
  CHECK_THROWS_AS(Read({"--daat", "/tmp/x"}), ConfigError);
}

}  // namespace
}  // namespace freelsd
