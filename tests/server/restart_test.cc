// The program itself, killed and started again.
#include <csignal>

#include <doctest/doctest.h>
#include <unistd.h>

#include "tests/server/child.h"
#include "tests/server/sample_flight.h"

namespace freelsd {
namespace {

TEST_CASE("restart: what was acknowledged before a kill is there after it, and the batch goes on") {
  constexpr int kNumImages = 12;
  const TemporaryFolder folder;
  std::string flight;
  std::string job;
  {
    Child child({folder.path()});
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
  Child child({folder.path()});
  httplib::Client client = ClientOf(child.AwaitPort());
  CHECK(FrameList(client, flight).size() == kNumImages + 1);
  CHECK(AwaitJob(client, job)["state"] == "done");
  const nlohmann::json list = GetJson(client, "/v1/jobs");
  for (const auto& unfinished : list["jobs"]) {
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
    Child child({folder.path()});
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
  Child child({folder.path()});
  httplib::Client client = ClientOf(child.AwaitPort());
  CHECK(FrameList(client, flight).empty());
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(folder.path() / "data/images")) {
    CHECK_FALSE(entry.is_regular_file());
  }
  CHECK(PutFrame(client, flight, "a.jpg", NoiseImage(1), SomeMeta())->status == 201);
}

TEST_CASE("restart: killed while it evaluates, it ends the job by itself, sites found are served") {
  const TemporaryFolder folder;
  const ChildOptions options{folder.path(), RealModel()};
  std::string flight;
  std::string second_job;
  nlohmann::json sites_before;
  {
    Child child(options);
    httplib::Client client = ClientOf(child.AwaitPort());
    flight = PostSampleFlight(client, 0, kNumSampleFrames - 1);
    REQUIRE(AwaitJob(client, Finish(client, flight))["state"] == "done");
    sites_before = SiteIds(client, flight);
    REQUIRE_FALSE(sites_before.empty());
    PostSampleFrames(client, flight, kNumSampleFrames - 1, kNumSampleFrames);
    second_job = Finish(client, flight);
    REQUIRE(AwaitEvaluation(client, second_job));
    CHECK(child.Stop(SIGKILL) == -SIGKILL);
  }
  Child child(options);
  httplib::Client client = ClientOf(child.AwaitPort());
  CHECK(SiteIds(client, flight) == sites_before);
  CHECK(GetJson(client, "/v1/jobs/" + second_job)["state"] != "done");
  CHECK(AwaitJob(client, second_job)["state"] == "done");
  CHECK_FALSE(SiteIds(client, flight).empty());
  CHECK(GetJson(client, "/v1/flights/" + flight)["state"] == "idle");
}

TEST_CASE("restart: SIGTERM ends the program cleanly within 10 s") {
  const TemporaryFolder folder;
  Child child({folder.path()});
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
  Child child({folder.path(), TestModel(), "127.0.0.1:" + std::to_string(fresh.server.port())});
  CHECK(child.Wait() > 0);
  CHECK(child.Output().find("the port is taken") != std::string::npos);
}

TEST_CASE("restart: an address that is not loopback ends the program with a sentence and a code") {
  const TemporaryFolder folder;
  Child child({folder.path(), TestModel(), "0.0.0.0:0"});
  CHECK(child.Wait() == 78);
  CHECK(child.Output().find("not a loopback address") != std::string::npos);
}

}  // namespace
}  // namespace freelsd
