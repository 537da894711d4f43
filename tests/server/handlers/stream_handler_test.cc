// A live camera: one long multipart request.
#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

std::string PartOf(const std::string& headers, const std::string& content) {
  return "--xyz\r\n" + headers + "\r\n\r\n" + content + "\r\n";
}

std::string MetaPart(int number) {
  return PartOf("Content-Type: application/json", SomeMeta(number));
}

std::string ImagePart(int number) {
  return PartOf("Content-Type: image/jpeg\r\nContent-Disposition: attachment; filename=\"" +
                    std::to_string(number) + ".jpg\"",
                NoiseImage(number));
}

constexpr char kType[] = "multipart/mixed; boundary=xyz";

TEST_CASE("stream: each part is stored, a damaged image is told of and ends nothing") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string damaged = PartOf("Content-Type: image/jpeg", NoiseImage(7).substr(0, 9000));
  const auto result = fresh.client.Post("/v1/flights/" + flight + "/stream",
                                        MetaPart(1) + ImagePart(1) + MetaPart(2) + damaged +
                                            MetaPart(3) + ImagePart(3) + "--xyz--\r\n",
                                        kType);
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 200);
  const nlohmann::json answer = nlohmann::json::parse(result->body);
  CHECK(answer["accepted"] == 2);
  REQUIRE(answer["rejected"].size() == 1);
  CHECK(answer["rejected"][0]["code"] == "DamagedImage");
  const nlohmann::json frames = FrameList(fresh.client, flight);
  REQUIRE(frames.size() == 2);
  CHECK(frames[0]["id"] == "1.jpg");
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight)["frames"]["rejected"] == 1);
}

TEST_CASE("stream: sent again, what is there is not there twice") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string body = MetaPart(1) + ImagePart(1) + MetaPart(2) + ImagePart(2) + "--xyz--\r\n";
  for (int i = 0; i < 2; ++i) {
    const auto result = fresh.client.Post("/v1/flights/" + flight + "/stream", body, kType);
    REQUIRE(result->status == 200);
    CHECK(nlohmann::json::parse(result->body)["accepted"] == 2);
  }
  CHECK(FrameList(fresh.client, flight).size() == 2);
}

TEST_CASE("stream: frames are durable as they arrive, and a cut connection loses none of them") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  {
    const RawConnection connection(fresh.server.port());
    connection.Send("POST /v1/flights/" + flight +
                    "/stream HTTP/1.1\r\nHost: localhost\r\nContent-Type: " + kType +
                    "\r\nTransfer-Encoding: chunked\r\n\r\n");
    const auto chunk = [&](const std::string& text) {
      char size[32];
      std::snprintf(size, sizeof(size), "%zx\r\n", text.size());
      connection.Send(size + text + "\r\n");
    };
    // The third part's beginning ends the second.
    chunk(MetaPart(1) + ImagePart(1));
    chunk(MetaPart(2) + ImagePart(2) + "--xyz\r\nContent-Type: image/jpeg\r\n\r\nhalf");
    for (int i = 0; FrameList(fresh.client, flight).size() < 2 && i < 400; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    CHECK(FrameList(fresh.client, flight).size() == 2);
  }
  CHECK(FrameList(fresh.client, flight).size() == 2);
}

TEST_CASE("stream: a camera that is faster than the engine is slowed down, not refused") {
  // The engine keeps some frames for itself, which count as queued.
  constexpr int kNumFrames = 40;
  FreshServer fresh([](Config& config) { config.max_num_queued_frames = 16; });
  const std::string flight = NewFlight(fresh.client);
  std::string body;
  for (int i = 0; i < kNumFrames; ++i) body += MetaPart(i) + ImagePart(i);
  const auto result =
      fresh.client.Post("/v1/flights/" + flight + "/stream", body + "--xyz--\r\n", kType);
  REQUIRE(result);
  CHECK(nlohmann::json::parse(result->body)["accepted"] == kNumFrames);
}

TEST_CASE("stream: a time of its own stands in for a meta part, and telemetry gives the pose") {
  FreshServer fresh([](Config& config) { config.telemetry_wait_s = 0.1; });
  // A single frame has no neighbours to tell its height, so the ground is taken as a plane.
  const auto posted =
      fresh.client.Post("/v1/flights",
                        R"({"name":"one frame","origin":{"latitude_deg":47,"longitude_deg":8,)"
                        R"("altitude_m":400},"camera":{"width_px":320,)"
                        R"("height_px":240,"fx_px":300,"fy_px":300,"cx_px":160,)"
                        R"("cy_px":120},"options":{"tracks":)"
                        R"({"assume_ground_plane":true}}})",
                        "application/json");
  REQUIRE(posted->status == 201);
  const std::string flight = nlohmann::json::parse(posted->body).at("id");
  const auto telemetry = fresh.client.Post(
      "/v1/flights/" + flight + "/telemetry",
      R"({"timestamp_us":77000000,"position":{"latitude_deg":47,"longitude_deg":8,)"
      R"("altitude_m":500},"attitude":{"roll_deg":0,"pitch_deg":0,"yaw_deg":0}})",
      "");
  CHECK(telemetry->status == 200);
  const std::string body =
      PartOf("Content-Type: image/jpeg\r\nX-Timestamp-Us: 77000000", NoiseImage(1)) + "--xyz--\r\n";
  const auto result = fresh.client.Post("/v1/flights/" + flight + "/stream", body, kType);
  CHECK(nlohmann::json::parse(result->body)["accepted"] == 1);
  const auto finish = fresh.client.Post("/v1/flights/" + flight + "/finish");
  AwaitJob(fresh.client, nlohmann::json::parse(finish->body)["id"]);
  CHECK(FrameList(fresh.client, flight)[0]["state"] == "processed");
}

TEST_CASE("stream: what is no stream is refused") {
  FreshServer fresh;
  const std::string path = "/v1/flights/" + NewFlight(fresh.client) + "/stream";
  CheckProblem(fresh.client.Post(path, "x", "text/plain"), 415, "UnsupportedMediaType");
  CheckProblem(fresh.client.Post(path, PartOf("Content-Type: text/plain", "x") + "--xyz--", kType),
               422,
               "UnknownPart");
}

}  // namespace
}  // namespace freelsd
