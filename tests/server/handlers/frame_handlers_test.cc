// One frame at a time.
#include <doctest/doctest.h>
#include <openssl/evp.h>
#include <openssl/sha.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// "sha-256=:…:" of these bytes, computed beside the server's own code.
std::string ReprDigest(const std::string& bytes) {
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest);
  unsigned char base64[64];
  EVP_EncodeBlock(base64, digest, SHA256_DIGEST_LENGTH);
  return "sha-256=:" + std::string(reinterpret_cast<char*>(base64)) + ":";
}

TEST_CASE("frames: a frame is 201 once, 200 again, and 409 with another image or meta") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string image = NoiseImage(1);
  CHECK(PutFrame(fresh.client, flight, "one", image, SomeMeta())->status == 201);
  CHECK(PutFrame(fresh.client, flight, "one", image, SomeMeta())->status == 200);
  CheckProblem(
      PutFrame(fresh.client, flight, "one", NoiseImage(2), SomeMeta()), 409, "FrameConflict");
  CheckProblem(PutFrame(fresh.client, flight, "one", image, SomeMeta(5)), 409, "FrameConflict");
  CHECK(PutFrame(fresh.client, flight, "same-image", image, SomeMeta())->status == 201);
  CHECK(FrameList(fresh.client, flight).size() == 2);
  CHECK(FrameList(fresh.client, flight)[0]["id"] == "one");
}

TEST_CASE("frames: the same meta in other words is the same frame") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string image = NoiseImage(1);
  nlohmann::json meta = nlohmann::json::parse(SomeMeta());
  CHECK(PutFrame(fresh.client, flight, "one", image, meta.dump(4))->status == 201);
  CHECK(PutFrame(fresh.client, flight, "one", image, meta.dump())->status == 200);
}

TEST_CASE("frames: POST gives the id, parts may come in any order and with any type") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/frames";
  const auto result = fresh.client.Post(
      path,
      {{"meta", SomeMeta(), "meta.txt", "text/plain"}, {"image", NoiseImage(1), "x", "text/html"}});
  REQUIRE(result);
  CHECK(result->status == 201);
  const std::string id = nlohmann::json::parse(result->body)["id"];
  CHECK(FrameList(fresh.client, flight)[0]["id"] == id);
  CHECK(
      fresh.client.Post(path, ImageAndMeta(NoiseImage(2, 320, 240, ".png"), SomeMeta(1)))->status ==
      201);
}

TEST_CASE("frames: the body's first bytes decide, whatever the content type says") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/frames/one";
  for (const char* type :
       {"", "application/octet-stream", "application/x-www-form-urlencoded", "image/png"}) {
    // Understood as an image; it has no position of its own.
    CheckProblem(fresh.client.Put(path, NoiseImage(1), type), 422, "NoPosition");
    CheckProblem(fresh.client.Put(path, "GIF89a and more", type), 415, "UnsupportedImage");
  }
}

TEST_CASE("frames: a digest that does not match is 422, one that does is taken") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/frames/one";
  const std::string image = NoiseImage(1);
  const httplib::Headers wrong{{"Repr-Digest", ReprDigest("something else")}};
  const httplib::Headers right{{"Repr-Digest", ReprDigest(image)}};
  CheckProblem(
      fresh.client.Put(path, wrong, ImageAndMeta(image, SomeMeta())), 422, "DigestMismatch");
  CHECK(FrameList(fresh.client, flight).empty());
  CHECK(fresh.client.Put(path, right, ImageAndMeta(image, SomeMeta()))->status == 201);
}

TEST_CASE("frames: an image of another size than the camera's names both sizes") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client, 640, 480);
  const auto result = PutFrame(fresh.client, flight, "one", NoiseImage(1), SomeMeta());
  CheckProblem(result, 422, "ImageSizeMismatch");
  CHECK(result->body.find("320x240") != std::string::npos);
  CHECK(result->body.find("640x480") != std::string::npos);
}

TEST_CASE("frames: without a camera from anywhere the frame is refused") {
  FreshServer fresh;
  const auto flight = fresh.client.Post("/v1/flights", R"({"name":"no camera"})", "");
  const std::string id = nlohmann::json::parse(flight->body)["id"];
  CheckProblem(PutFrame(fresh.client, id, "one", NoiseImage(1), SomeMeta()), 422, "NoCamera");
}

TEST_CASE("frames: an id with other characters is refused") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  CheckProblem(
      PutFrame(fresh.client, flight, "a%20b", NoiseImage(1), SomeMeta()), 422, "InvalidId");
  CheckProblem(PutFrame(fresh.client, flight, "..", NoiseImage(1), SomeMeta()), 422, "InvalidId");
}

TEST_CASE("frames: a full queue is 429, but not for a repeat of what is stored") {
  FreshServer fresh([](Config& config) { config.max_num_queued_frames = 1; });
  const std::string flight = NewFlight(fresh.client);
  // Without attitude or height the first frame waits in the engine for its neighbours.
  const std::string meta = R"({"position":{"latitude_deg":47,"longitude_deg":8,"altitude_m":500}})";
  CHECK(PutFrame(fresh.client, flight, "one", NoiseImage(1), meta)->status == 201);
  const auto full = PutFrame(fresh.client, flight, "two", NoiseImage(2), meta);
  CheckProblem(full, 429, "QueueFull");
  CHECK(full->has_header("Retry-After"));
  CHECK(PutFrame(fresh.client, flight, "one", NoiseImage(1), meta)->status == 200);
}

TEST_CASE("frames: what was sent is processed, and the flight told of it") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  for (int i = 0; i < 3; ++i) {
    PutFrame(fresh.client, flight, std::to_string(i), NoiseImage(i), SomeMeta(i));
  }
  const auto finish = fresh.client.Post("/v1/flights/" + flight + "/finish");
  REQUIRE(finish->status == 202);
  const std::string job = nlohmann::json::parse(finish->body)["id"];
  const nlohmann::json state = AwaitJob(fresh.client, job);
  INFO(state.dump());
  CHECK(state["state"] == "done");
  const nlohmann::json told = GetJson(fresh.client, "/v1/flights/" + flight);
  CHECK(told["state"] == "idle");
  CHECK(told["frames"]["received"] == 3);
  CHECK(told["frames"]["processed"] == 3);
  CHECK(told["stages"].contains("tracks"));
  // Nothing new: done at once.
  const auto again = fresh.client.Post("/v1/flights/" + flight + "/finish");
  CHECK(nlohmann::json::parse(again->body)["state"] == "done");
}

TEST_CASE("frames: finish of an empty flight is done at once") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto finish = fresh.client.Post("/v1/flights/" + flight + "/finish");
  CHECK(finish->status == 202);
  CHECK(nlohmann::json::parse(finish->body)["state"] == "done");
}

TEST_CASE("frames: a deleted flight is gone with its frames and jobs") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  PutFrame(fresh.client, flight, "one", NoiseImage(1), SomeMeta());
  CHECK(fresh.client.Delete("/v1/flights/" + flight)->status == 204);
  CheckProblem(fresh.client.Get("/v1/flights/" + flight), 404, "NoSuchFlight");
  CheckProblem(fresh.client.Delete("/v1/flights/" + flight), 404, "NoSuchFlight");
  CHECK(GetJson(fresh.client, "/v1/flights")["flights"].empty());
}

}  // namespace
}  // namespace freelsd
