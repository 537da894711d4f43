// The program itself, killed and started again.
#include <csignal>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// freelsd-server as a child; killed at the end if it still runs.
class Child {
 public:
  Child(const std::filesystem::path& folder, const std::string& listen)
      : output_(folder / "output.txt") {
    const std::string data = folder / "data";
    const std::string model = TestModel();
    std::filesystem::remove(output_);
    process_ = ::fork();
    if (process_ != 0) return;
    const int descriptor = ::open(output_.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
    ::dup2(descriptor, 1);
    ::dup2(descriptor, 2);
    ::execl(FREELSD_SERVER,
            "freelsd-server",
            "--data",
            data.c_str(),
            "--listen",
            listen.c_str(),
            "--model",
            model.c_str(),
            nullptr);
    ::_exit(127);
  }
  ~Child() {
    if (process_ > 0) Stop(SIGKILL);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The port it says it listens on.
  int AwaitPort() const {
    const std::string key = "listens on http://127.0.0.1:";
    for (int i = 0; i < 1000; ++i) {
      const std::string text = Output();
      const size_t at = text.find(key);
      if (at != std::string::npos) return std::stoi(text.substr(at + key.size()));
      ::usleep(10000);
    }
    FAIL("the server did not start: " << Output());
    return 0;
  }
  // Exit code, or minus the signal.
  int Wait() {
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  int Stop(int signal) {
    ::kill(process_, signal);
    return Wait();
  }
  std::string Output() const {
    std::ifstream file(output_);
    return std::string(std::istreambuf_iterator<char>(file), {});
  }

 private:
  std::filesystem::path output_;
  pid_t process_ = -1;
};

httplib::Client ClientOf(int port) {
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(30);
  return client;
}

TEST_CASE("restart: what was acknowledged before a kill is there after it, and the batch goes on") {
  constexpr int kNumImages = 12;
  const TemporaryFolder folder;
  std::string flight;
  std::string job;
  {
    Child child(folder.path(), "127.0.0.1:0");
    httplib::Client client = ClientOf(child.AwaitPort());
    flight = NewFlight(client);
    CHECK(PutFrame(client, flight, "single", NoiseImage(99), SomeMeta())->status == 201);
    httplib::MultipartFormDataItems items;
    std::string poses = "image,latitude_deg,longitude_deg,altitude_m\n";
    for (int i = 0; i < kNumImages; ++i) {
      const std::string name = std::to_string(i) + ".jpg";
      items.push_back({"images", NoiseImage(i), name, "image/jpeg"});
      poses += name + ",47.000" + std::to_string(i) + ",8.0,500\n";
    }
    items.push_back({"poses", poses, "poses.csv", "text/csv"});
    const auto batch = client.Post("/v1/flights/" + flight + "/batch", items);
    REQUIRE(batch);
    REQUIRE(batch->status == 202);
    job = nlohmann::json::parse(batch->body)["id"];
    const auto finish = client.Post("/v1/flights/" + flight + "/finish");
    CHECK(finish->status == 202);
    CHECK(child.Stop(SIGKILL) == -SIGKILL);
  }
  Child child(folder.path(), "127.0.0.1:0");
  httplib::Client client = ClientOf(child.AwaitPort());
  CHECK(FrameList(client, flight).size() == kNumImages + 1);
  CHECK(AwaitJob(client, job)["state"] == "done");
  for (const auto& unfinished : GetJson(client, "/v1/jobs")["jobs"]) {
    CHECK(AwaitJob(client, unfinished["id"])["state"] == "done");
  }
  const nlohmann::json told = GetJson(client, "/v1/flights/" + flight);
  CHECK(told["frames"]["processed"] == kNumImages + 1);
  CHECK(told["state"] == "idle");
}

TEST_CASE("restart: killed in the middle of an upload, nothing of it is there and it can be sent") {
  const TemporaryFolder folder;
  std::string flight;
  {
    Child child(folder.path(), "127.0.0.1:0");
    const int port = child.AwaitPort();
    httplib::Client client = ClientOf(port);
    flight = NewFlight(client);
    RawConnection connection(port);
    connection.Send("POST /v1/flights/" + flight +
                    "/batch HTTP/1.1\r\nHost: localhost\r\nContent-Length: 900000\r\n"
                    "Content-Type: multipart/form-data; boundary=xyz\r\n\r\n"
                    "--xyz\r\nContent-Disposition: form-data; name=\"images\"; "
                    "filename=\"a.jpg\"\r\n\r\n" +
                    NoiseImage(1) +
                    "\r\n--xyz\r\nContent-Disposition: form-data; name=\"images\"; "
                    "filename=\"b.jpg\"\r\n\r\nhalf");
    ::usleep(300000);
    child.Stop(SIGKILL);
  }
  Child child(folder.path(), "127.0.0.1:0");
  httplib::Client client = ClientOf(child.AwaitPort());
  CHECK(FrameList(client, flight).empty());
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder.path() / "data/images")) {
    CHECK_FALSE(entry.is_regular_file());
  }
  CHECK(PutFrame(client, flight, "a.jpg", NoiseImage(1), SomeMeta())->status == 201);
}

TEST_CASE("restart: SIGTERM ends the program cleanly within 10 s") {
  const TemporaryFolder folder;
  Child child(folder.path(), "127.0.0.1:0");
  httplib::Client client = ClientOf(child.AwaitPort());
  client.set_keep_alive(true);
  const std::string flight = NewFlight(client);
  for (int i = 0; i < 5; ++i) {
    PutFrame(client, flight, std::to_string(i), NoiseImage(i), SomeMeta(i));
  }
  client.Post("/v1/flights/" + flight + "/finish");
  const auto begin = std::chrono::steady_clock::now();
  CHECK(child.Stop(SIGTERM) == 0);
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(10));
}

TEST_CASE("restart: a taken port ends the program with a sentence and a code") {
  const FreshServer fresh;
  const TemporaryFolder folder;
  Child child(folder.path(), "127.0.0.1:" + std::to_string(fresh.server.port()));
  CHECK(child.Wait() > 0);
  CHECK(child.Output().find("the port is taken") != std::string::npos);
}

TEST_CASE("restart: an address that is not loopback ends the program with a sentence and a code") {
  const TemporaryFolder folder;
  Child child(folder.path(), "0.0.0.0:0");
  CHECK(child.Wait() == 78);
  CHECK(child.Output().find("not a loopback address") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
