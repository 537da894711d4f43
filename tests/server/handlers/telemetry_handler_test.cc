// Telemetry, and frames that get their pose from it.
#include <cmath>

#include <doctest/doctest.h>

#include "server/intake/telemetry.h"
#include "tests/api/export/sites/readers.h"
#include "tests/server/meadow.h"
#include "tests/server/sample_flight.h"
#include "tests/server/site_on_map.h"

namespace freelsd {
namespace {

constexpr int64_t kStart = 1700000000000000;

std::string Line(int64_t timestamp_us, double latitude_deg, double yaw_deg) {
  return nlohmann::json{
             {"timestamp_us", timestamp_us},
             {"position",
              {{"latitude_deg", latitude_deg}, {"longitude_deg", 8.0}, {"altitude_m", 500.0}}},
             {"attitude", {{"roll_deg", 0.0}, {"pitch_deg", 0.0}, {"yaw_deg", yaw_deg}}},
             {"wind", {{"east_mps", 1.0}, {"north_mps", -2.0}}}}
             .dump() +
         "\n";
}

std::string TimeOnly(int64_t timestamp_us) {
  return nlohmann::json{{"timestamp_us", timestamp_us}}.dump();
}

// A single frame has no neighbours to tell its height.
std::string TimeAndHeight(int64_t timestamp_us) {
  return nlohmann::json{{"timestamp_us", timestamp_us}, {"height_above_ground_m", 100.0}}.dump();
}

nlohmann::json PostTelemetry(httplib::Client& client,
                             const std::string& flight,
                             const std::string& lines) {
  const auto result = client.Post("/v1/flights/" + flight + "/telemetry", lines, "");
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 200);
  return nlohmann::json::parse(result->body);
}

// The first frame, after the engine has processed all frames. Before `finish`, the engine may keep
// the last one.
nlohmann::json FinishedFrame(httplib::Client& client, const std::string& flight) {
  const auto finish = client.Post("/v1/flights/" + flight + "/finish");
  CHECK(AwaitJob(client, nlohmann::json::parse(finish->body)["id"])["state"] == "done");
  return FrameList(client, flight).at(0);
}

TEST_CASE("telemetry: an upload to a flight that is deleted meanwhile is 404") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto chunk_of = [](const std::string& line) {
    char size[8];
    std::snprintf(size, sizeof(size), "%zx", line.size());
    return size + ("\r\n" + line + "\r\n");
  };
  RawConnection upload(fresh.server.port());
  upload.Send("POST /v1/flights/" + flight +
              "/telemetry HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" +
              chunk_of(Line(kStart, 47.0, 0.0)));
  // The upload has begun once its flight is receiving.
  std::string state;
  for (int i = 0; state != "receiving" && i < 500; ++i) {
    state = GetJson(fresh.client, "/v1/flights/" + flight)["state"];
  }
  CHECK(state == "receiving");
  CHECK(fresh.client.Delete("/v1/flights/" + flight)->status == 204);
  upload.Send(chunk_of(Line(kStart + 1000000, 47.0, 0.0)) + "0\r\n\r\n");
  const std::string answer = upload.Receive();
  CHECK(answer.starts_with("HTTP/1.1 404"));
  CHECK(answer.find("NoSuchFlight") != std::string::npos);
}

TEST_CASE("telemetry: good lines are taken, bad ones told of with their number") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const nlohmann::json answer = PostTelemetry(
      fresh.client,
      flight,
      Line(kStart, 47.0, 0.0) + "\n{\"timestamp_us\":NaN}\n" + "{\"position\":null}\n" +
          R"({"timestamp_us":5,"colour":"green"})" + "\n" + std::string(20000, ' ') + "x\n" +
          R"({"timestamp_us":6,"position":{"latitude_deg":95,"longitude_deg":8,"altitude_m":1}})" +
          "\n" + TimeOnly(kStart + 1));
  CHECK(answer["accepted"] == 2);
  REQUIRE(answer["rejected"].size() == 5);
  CHECK(answer["rejected"][0]["line"] == 3);
  CHECK(answer["rejected"][3]["line"] == 6);
  CHECK(answer["rejected"][4]["line"] == 7);
  CheckProblem(fresh.client.Post("/v1/flights/none/telemetry"), 404, "NoSuchFlight");
}

TEST_CASE("telemetry: a frame between two samples gets the pose between them") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  PostTelemetry(
      fresh.client, flight, Line(kStart, 47.0, 350.0) + Line(kStart + 1000000, 47.0001, 10.0));
  const auto put =
      PutFrame(fresh.client, flight, "one", NoiseImage(1), TimeAndHeight(kStart + 500000));
  CHECK(put->status == 201);
  CHECK(FinishedFrame(fresh.client, flight)["state"] == "processed");
}

TEST_CASE("telemetry: a frame that comes before its telemetry waits for it") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  CHECK(PutFrame(fresh.client, flight, "one", NoiseImage(1), TimeAndHeight(kStart + 500000))
            ->status == 201);
  CHECK(FrameList(fresh.client, flight)[0]["state"] == "queued");
  PostTelemetry(
      fresh.client, flight, Line(kStart, 47.0, 0.0) + Line(kStart + 1000000, 47.0001, 0.0));
  CHECK(FinishedFrame(fresh.client, flight)["state"] == "processed");
}

TEST_CASE("telemetry: a frame that nothing covers is rejected after its time, the rest goes on") {
  FreshServer fresh([](Config& config) { config.telemetry_wait_s = 0.1; });
  const std::string flight = NewFlight(fresh.client);
  PostTelemetry(fresh.client, flight, Line(kStart, 47.0, 0.0));
  PutFrame(fresh.client, flight, "late", NoiseImage(1), TimeOnly(kStart + 5000000));
  CHECK(PutFrame(fresh.client, flight, "known", NoiseImage(2), SomeMeta(1))->status == 201);
  const auto finish = fresh.client.Post("/v1/flights/" + flight + "/finish");
  const std::string job = nlohmann::json::parse(finish->body)["id"];
  CHECK(AwaitJob(fresh.client, job)["state"] == "done");
  const nlohmann::json frames = FrameList(fresh.client, flight);
  CHECK(frames[0]["state"] == "rejected");
  CHECK(frames[0]["reason"].get<std::string>().find("telemetry") != std::string::npos);
  CHECK(frames[1]["state"] == "processed");
}

TEST_CASE("telemetry: without time and position a frame is refused at once") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  CheckProblem(PutFrame(fresh.client, flight, "one", NoiseImage(1), "{}"), 422, "NoPosition");
}

TEST_CASE("telemetry: lines of a long chunked upload are durable while it goes on") {
  const TemporaryFolder folder;
  const TestServer server(TestConfig(folder.path() / "data"));
  httplib::Client client = server.Client();
  const std::string flight = NewFlight(client);
  const RawConnection connection(server.port());
  const auto chunk = [&](const std::string& text) {
    char size[32];
    std::snprintf(size, sizeof(size), "%zx\r\n", text.size());
    connection.Send(size + text + "\r\n");
  };
  connection.Send("POST /v1/flights/" + flight +
                  "/telemetry HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
  // Until the pose is known: the upload never ends.
  const std::string alternates = "/v1/flights/" + flight + "/alternates";
  for (int i = 0; !GetJson(client, alternates).contains("pose") && i < 400; ++i) {
    chunk(Line(kStart + int64_t{20000} * i, 47.0 + i * 1e-6, 0.0));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  CHECK(GetJson(client, alternates).contains("pose"));
  CHECK(GetJson(client, "/v1/flights/" + flight)["state"] != "idle");
}

TEST_CASE("telemetry: attitude turns the short way, positions go straight, nothing goes too far") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  FlightRow flight;
  flight.id = std::string("f");
  storage.flights.Insert(flight);
  for (const std::string& line : {Line(kStart, 47.0, 350.0), Line(kStart + 1000000, 48.0, 10.0)}) {
    storage.telemetry.Put("f", ParseTelemetryLine(line));
  }
  const Config config;
  const FrameMeta middle = TelemetryAt(storage, config, "f", kStart + 250000);
  REQUIRE(middle.position);
  CHECK(middle.position->latitude_deg == doctest::Approx(47.25));
  REQUIRE(middle.ned_from_body);
  const Eigen::Vector3d nose = *middle.ned_from_body * Eigen::Vector3d::UnitX();
  const double yaw_deg = std::atan2(nose.y(), nose.x()) * 180.0 / 3.14159265358979;
  CHECK(yaw_deg == doctest::Approx(-5.0));
  CHECK(middle.wind_in_world->y() == doctest::Approx(-2.0));
  // Held for 0.2 s, then unknown.
  CHECK(TelemetryAt(storage, config, "f", kStart + 1150000).position);
  CHECK_FALSE(TelemetryAt(storage, config, "f", kStart + 1250000).position);
  CHECK_FALSE(TelemetryAt(storage, config, "f", kStart - 250000).position);
  storage.telemetry.Put("f", ParseTelemetryLine(Line(kStart + 9000000, 49.0, 0.0)));
  CHECK_FALSE(TelemetryAt(storage, config, "f", kStart + 5000000).position);
}

TEST_CASE("telemetry: winds between two frames are found where the aircraft was") {
  const TemporaryFolder folder;
  Storage storage(StorageAt(folder.path()));
  FlightRow flight;
  flight.id = std::string("f");
  storage.flights.Insert(flight);
  for (int i = 0; i <= 10; ++i) {
    storage.telemetry.Put(
        "f", ParseTelemetryLine(Line(kStart + int64_t{100000} * i, 47.0 + 0.001 * i, 0.0)));
  }
  // Without a position near in time.
  storage.telemetry.Put("f", {{TelemetryKind::kWind, kStart + 30000000, {9.0, 9.0, 0.0, 0.0}}});
  const auto between = [&](int64_t after_us, int64_t before_us) {
    return WindsBetween(storage, Config{}, "f", kStart + after_us, kStart + before_us);
  };
  const std::vector<MeasuredWind> winds = between(200000, 600000);
  REQUIRE(winds.size() == 3);
  CHECK(winds[0].timestamp_us == kStart + 300000);
  CHECK(winds[2].place.latitude_deg == doctest::Approx(47.005));
  CHECK(winds[1].wind_in_world == Eigen::Vector2d(1.0, -2.0));
  CHECK(between(200000, 300000).empty());
  CHECK(between(600000, 200000).empty());
  CHECK(between(1000000, 60000000).empty());
}

// Telemetry halfway between the frames of the file, with this wind.
std::string WindsHalfway(const std::string& poses, double wind_east_mps) {
  const auto rows = SplitRows(poses, ',');
  std::string lines;
  for (size_t i = 2; i < rows.size(); ++i) {
    const auto middle = [&](size_t column) {
      return 0.5 * (std::stod(rows[i - 1].at(column)) + std::stod(rows[i].at(column)));
    };
    lines += nlohmann::json{{"timestamp_us", static_cast<int64_t>(middle(4))},
                            {"position",
                             {{"latitude_deg", middle(1)},
                              {"longitude_deg", middle(2)},
                              {"altitude_m", middle(3)}}},
                            {"wind", {{"east_mps", wind_east_mps}, {"north_mps", 0.0}}}}
                 .dump() +
             "\n";
  }
  return lines;
}

TEST_CASE("telemetry: a wind between the frames counts in the wind of a region") {
  FreshServer fresh([](Config& config) { config.model = RealModel(); });
  const std::string flight = PostSampleFlight(fresh.client, 0, 1);
  const std::string poses = SamplePoses(0, kNumSampleFrames);
  double framed_east_mps = 0.0;
  const auto rows = SplitRows(poses, ',');
  for (size_t i = 1; i < rows.size(); ++i) framed_east_mps += std::stod(rows[i].at(8));
  framed_east_mps /= static_cast<double>(kNumSampleFrames);
  PostTelemetry(fresh.client, flight, WindsHalfway(poses, framed_east_mps + 10.0));
  PostSampleFrames(fresh.client, flight, 1, kNumSampleFrames);
  const nlohmann::json jobs = GetJson(fresh.client, "/v1/jobs")["jobs"];
  for (const auto& job : jobs) CHECK(AwaitJob(fresh.client, job["id"])["state"] == "done");
  const nlohmann::json regions =
      GetJson(fresh.client, "/v1/flights/" + flight + "/regions")["features"];
  REQUIRE(!regions.empty());
  for (const auto& region : regions) {
    REQUIRE(region["properties"]["wind"].is_object());
    // Half of the samples are from between the frames. Without them it is within 1 m/s.
    CHECK(region["properties"]["wind"]["east_mps"].get<double>() > framed_east_mps + 3.0);
  }
}

TEST_CASE("alternates: the best sites from the latest pose stand ready, and follow it") {
  MeadowServer meadow([](Storage& storage) { PutOnMap(storage, MeadowSite("amsl"), Meadow()); });
  httplib::Client& client = *meadow.client;
  const auto made =
      client.Post("/v1/flights",
                  R"({"name":"x","altitude_datum":"amsl","aircraft":{"profile":"small"}})",
                  "application/json");
  const std::string flight = nlohmann::json::parse(made->body)["id"];
  const std::string path = "/v1/flights/" + flight + "/alternates";
  CHECK(GetJson(client, path)["sites"].empty());
  PostTelemetry(client,
                flight,
                R"({"timestamp_us":1,"position":{"latitude_deg":46.9955,"longitude_deg":8,)"
                R"("altitude_m":900},"wind":{"east_mps":0,"north_mps":0}})");
  nlohmann::json answer;
  for (int i = 0; i < 400 && (answer.is_null() || answer["sites"].empty()); ++i) {
    answer = GetJson(client, path);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  REQUIRE(answer["sites"].size() == 1);
  CHECK(answer["sites"][0]["site_id"] == "f-r1");
  CHECK(answer["pose"]["altitude_m"] == 900.0);
  CheckProblem(client.Get("/v1/flights/none/alternates"), 404, "NoSuchFlight");
}

}  // namespace
}  // namespace freelsd
