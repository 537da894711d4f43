// A disk without space: writes are 507, reads go on, and space that returns is used.
#include <cstring>

#include <doctest/doctest.h>
#include <sys/mount.h>

#include "tests/server/child.h"

namespace freelsd {
namespace {

// A file system of its own size; nothing where this process may not mount.
class SmallDisk {
 public:
  explicit SmallDisk(const std::filesystem::path& folder) : folder_(folder) {
    std::filesystem::create_directories(folder_);
    is_mounted_ = ::mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=6m") == 0;
  }
  ~SmallDisk() {
    if (is_mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool is_mounted() const { return is_mounted_; }

 private:
  std::filesystem::path folder_;
  bool is_mounted_ = false;
};

// PNGs of noise do not shrink: about 230 kB each.
std::string LargeImage(int seed) { return NoiseImage(seed, 320, 240, ".png"); }

TEST_CASE(
    "full disk: an upload is 507 and stores nothing, reads go on, space that returns is used") {
  constexpr int kMaxNumUploads = 200;
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "data");
  if (!disk.is_mounted()) {
    MESSAGE("skipped: this process may not mount a small file system");
    return;
  }
  const TestServer server(TestConfig(folder.path() / "data"));
  httplib::Client client = server.Client();
  const std::string flight = NewFlight(client), unwanted = NewFlight(client);
  int num_stored = 0;
  httplib::Result result(nullptr, httplib::Error::Unknown);
  for (; num_stored < kMaxNumUploads; ++num_stored) {
    result = PutFrame(
        client, flight, std::to_string(num_stored), LargeImage(num_stored), SomeMeta(num_stored));
    REQUIRE(result);
    if (result->status != 201) break;
  }
  CheckProblem(result, 507, "StorageFull");
  REQUIRE(num_stored > 0);
  CHECK(FrameList(client, flight).size() == static_cast<size_t>(num_stored));
  CHECK(client.Get("/healthz")->status == 200);
  CHECK(client.Get("/readyz")->status == 503);
  CHECK(GetJson(client, "/v1/flights")["flights"].size() == 2);
  CHECK(client.Get("/v1/sites")->status == 200);
  // Small images do not find a place that large ones left.
  int num_small = 0;
  for (; num_small < kMaxNumUploads; ++num_small) {
    const std::string small = NoiseImage(1000 + num_small);
    result = PutFrame(client, flight, "s" + std::to_string(num_small), small, SomeMeta());
    REQUIRE(result);
    if (result->status != 201) break;
  }
  CheckProblem(result, 507, "StorageFull");
  const auto space = std::filesystem::space(folder.path() / "data");
  // Images leave the database room enough to make room.
  CHECK(space.available > space.capacity / 32);
  CHECK(client.Delete("/v1/flights/" + unwanted)->status == 204);
  // More room on the same disk; the server is not started again.
  const std::filesystem::path data = folder.path() / "data";
  REQUIRE(::mount("tmpfs", data.c_str(), "tmpfs", MS_REMOUNT, "size=64m") == 0);
  const std::string id = std::to_string(num_stored);
  CHECK(PutFrame(client, flight, id, LargeImage(num_stored), SomeMeta(num_stored))->status == 201);
  CHECK(FrameList(client, flight).size() == static_cast<size_t>(num_stored + num_small) + 1);
}

TEST_CASE("full disk: a file that cannot grow is 507 too, without any privilege to test it") {
  const TemporaryFolder folder;
  ChildOptions options{folder.path()};
  // Room for the database, not for the larger image.
  options.max_file_bytes = uint64_t{1} << 20;
  Child child(options);
  httplib::Client client = ClientOf(child.AwaitPort());
  const std::string flight = NewFlight(client, 1600, 1200);
  const std::string large = NoiseImage(1, 1600, 1200);
  REQUIRE(large.size() > options.max_file_bytes);
  CheckProblem(PutFrame(client, flight, "one", large, SomeMeta()), 507, "StorageFull");
  CHECK(FrameList(client, flight).empty());
  CHECK(GetJson(client, "/v1/flights")["flights"].size() == 1);
  // A zip goes through the spool first.
  CheckProblem(client.Post("/v1/flights/" + flight + "/batch",
                           "PK" + std::string(options.max_file_bytes * 2, 'x'),
                           "application/zip"),
               507,
               "StorageFull");
  CHECK(client.Get("/healthz")->status == 200);
}

}  // namespace
}  // namespace freelsd
