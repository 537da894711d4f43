// When frames were taken, as far as the server knows.
#include <doctest/doctest.h>

#include "server/http/http.h"
#include "tests/api/import/images/tagged_image.h"
#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int64_t kDayUs = int64_t{86400} * 1000000;
constexpr char kPosition[] =
    R"("position": {"latitude_deg": 47.0, "longitude_deg": 8.0, "altitude_m": 500.0})";

// As EXIF has it.
std::string DateOf(int64_t time_us) {
  std::string date = Rfc3339(time_us).substr(0, 10);
  date[4] = date[7] = ':';
  return date;
}

std::string MetaWith(const std::string& time) {
  return std::string("{") + (time.empty() ? "" : "\"timestamp_us\": " + time + ", ") + kPosition +
         "}";
}

nlohmann::json WarningsOf(httplib::Client& client, const std::string& flight) {
  return GetJson(client, "/v1/flights/" + flight)["warnings"];
}

bool Warns(const nlohmann::json& warnings, const std::string& part) {
  return warnings.dump().find(part) != std::string::npos;
}

TEST_CASE("photographs without a usable date: a frame of PUT takes its arrival, a batch never") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const int64_t before_us = NowUs();
  int number = 0;
  const std::string future = std::to_string(before_us + kDayUs / 2);
  for (const std::string& time : {std::string(), std::string("1"), future}) {
    const std::string id = "put" + std::to_string(number);
    CHECK(PutFrame(fresh.client, flight, id, NoiseImage(number++), MetaWith(time))->status == 201);
  }
  for (const nlohmann::json& frame : FrameList(fresh.client, flight)) {
    CHECK(frame["time_source"] == "arrival");
    CHECK(frame["timestamp_us"].get<int64_t>() >= before_us - 1000000);
    CHECK(frame["timestamp_us"].get<int64_t>() <= NowUs() + 1000000);
  }
  CHECK(Warns(WarningsOf(fresh.client, flight), "usable date") == false);

  const std::string in_batch = NewFlight(fresh.client);
  const std::string poses =
      "image,latitude_deg,longitude_deg,altitude_m,timestamp_us\n"
      "none.jpg,47,8,500,\nunset.jpg,47,8,500,1\nfuture.jpg,47,8,500," +
      future + "\n";
  httplib::MultipartFormDataItems items{{"poses", poses, "poses.csv", "text/csv"}};
  for (const char* const name : {"none.jpg", "unset.jpg", "future.jpg"}) {
    items.push_back({"images", NoiseImage(number++), name, "image/jpeg"});
  }
  const auto answer = fresh.client.Post("/v1/flights/" + in_batch + "/batch", items);
  REQUIRE(answer->status == 202);
  const auto frames = FrameList(fresh.client, in_batch);
  CHECK(frames.size() == 3);
  for (const nlohmann::json& frame : frames) {
    CHECK(frame["timestamp_us"].is_null());
    CHECK(frame["time_source"].is_null());
  }
  CHECK(Warns(nlohmann::json::parse(answer->body), "photographs have no usable date"));
  CHECK(Warns(WarningsOf(fresh.client, in_batch), "photographs have no usable date"));
}

TEST_CASE("photographs without a usable date: tags of the image tell their source") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string day = DateOf(NowUs() - 3 * kDayUs);
  const PhotoTimes local{day + " 14:00:00", "", "", {}};
  const PhotoTimes camera{day + " 14:00:00", "+02:00", "", {}};
  const PhotoTimes receiver{day + " 14:00:00", "", day, {12, 0, 0}};
  const std::vector<std::pair<PhotoTimes, std::string>> cases{
      {local, "camera_local"}, {camera, "camera"}, {receiver, "gps"}};
  httplib::MultipartFormDataItems items;
  for (const auto& [times, source] : cases) {
    const std::string image = WithGeotag(NoiseImage(static_cast<int>(items.size())), {}, times);
    items.push_back({"images", image, source + ".jpg", "image/jpeg"});
  }
  const auto answer = fresh.client.Post("/v1/flights/" + flight + "/batch", items);
  REQUIRE(answer->status == 202);
  const auto frames = FrameList(fresh.client, flight);
  REQUIRE(frames.size() == 3);
  for (const nlohmann::json& frame : frames) {
    const std::string id = frame["id"];
    CHECK(frame["time_source"] == id.substr(0, id.size() - 4));
    const int64_t hour = frame["timestamp_us"].get<int64_t>() % kDayUs / (kDayUs / 24);
    CHECK(hour == (id == "camera_local.jpg" ? 14 : 12));
  }
  CHECK(Warns(nlohmann::json::parse(answer->body), "have no offset from UTC"));
  CHECK_FALSE(Warns(nlohmann::json::parse(answer->body), "camera's clock"));
}

TEST_CASE("capture times that contradict the arrival of their card, a year behind, are warned of") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const PhotoTimes old{DateOf(NowUs() - 365 * kDayUs) + " 00:00:00", "+00:00", "", {}};
  const httplib::MultipartFormDataItems items{
      {"images", WithGeotag(NoiseImage(1), {}, old), "a.jpg", "image/jpeg"}};
  const auto answer = fresh.client.Post("/v1/flights/" + flight + "/batch", items);
  REQUIRE(answer->status == 202);
  CHECK(Warns(nlohmann::json::parse(answer->body),
              "the newest photograph is dated 365 days before it arrived: if it is new, the "
              "camera's clock is wrong"));
}

}  // namespace
}  // namespace freelsd
