// Files of other programs beside the images, over HTTP.
#include <set>

#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr int kNumImages = 4;
constexpr char kCameras[] = "# Camera list\n1 PINHOLE 320 240 300 300 160 120\n";

std::string NameOf(int i) { return std::to_string(i) + ".jpg"; }

httplib::MultipartFormDataItems Images() {
  httplib::MultipartFormDataItems items;
  for (int i = 0; i < kNumImages; ++i) {
    items.push_back({"images", NoiseImage(i), NameOf(i), "image/jpeg"});
  }
  return items;
}

httplib::MultipartFormData Beside(const std::string& name, const std::string& text) {
  return {"poses", text, name, "text/plain"};
}

std::string Geo(int num_images) {
  std::string text = "EPSG:4326\n";
  for (int i = 0; i < num_images; ++i) {
    text += NameOf(i) + " 8.0 47.000" + std::to_string(i) + " 500\n";
  }
  return text;
}

std::string FlightWithoutCamera(httplib::Client& client) {
  const auto result = client.Post("/v1/flights", R"({"name": "a test"})", "application/json");
  REQUIRE(result->status == 201);
  return nlohmann::json::parse(result->body)["id"];
}

httplib::Result Post(httplib::Client& client,
                     const std::string& flight,
                     const httplib::MultipartFormDataItems& items,
                     const std::string& query = "") {
  return client.Post("/v1/flights/" + flight + "/batch" + query, items);
}

TEST_CASE("import: geo.txt and a COLMAP camera make a flight, and are named in the answer") {
  FreshServer fresh;
  const std::string flight = FlightWithoutCamera(fresh.client);
  auto items = Images();
  items.push_back(Beside("geo.txt", Geo(kNumImages)));
  items.push_back(Beside("cameras.txt", kCameras));
  const auto result = Post(fresh.client, flight, items);
  INFO(result->body);
  REQUIRE(result->status == 202);
  const nlohmann::json job = nlohmann::json::parse(result->body);
  CHECK(job["detail"]["formats"][0]["format"] == "odm-geo");
  CHECK(job["detail"]["formats"][1]["format"] == "colmap-cameras");
  CHECK(AwaitJob(fresh.client, job["id"])["state"] == "done");
  const nlohmann::json told = GetJson(fresh.client, "/v1/flights/" + flight);
  CHECK(told["frames"]["processed"] == kNumImages);
  CHECK(told["camera"]["cx_px"] == 159.5);
}

TEST_CASE("import: a dry run tells every problem at once and stores nothing") {
  FreshServer fresh;
  const std::string flight = FlightWithoutCamera(fresh.client);
  auto items = Images();
  items[1].content = items[1].content.substr(0, 5000);
  items.push_back(Beside("geo.txt", Geo(kNumImages + 2)));
  const auto result = Post(fresh.client, flight, items, "?dry_run=true");
  REQUIRE(result->status == 200);
  const nlohmann::json answer = nlohmann::json::parse(result->body);
  CHECK(answer["would_be_refused"] == true);
  REQUIRE(answer["problems"].size() == 1);
  CHECK(answer["problems"][0]["code"] == "UnknownImages");
  CHECK(answer["problems"][0]["errors"].size() == 2);
  CHECK(answer["images"].size() == kNumImages);
  CHECK(answer["num_rejected"] == kNumImages);
  CHECK(answer["formats"][0]["format"] == "odm-geo");
  std::set<std::string> codes;
  for (const auto& image : answer["images"]) codes.insert(image["code"]);
  CHECK(codes == std::set<std::string>{"DamagedImage", "NoCamera"});
  CHECK(FrameList(fresh.client, flight).empty());
  CHECK(GetJson(fresh.client, "/v1/jobs")["jobs"].empty());
  CheckProblem(Post(fresh.client, flight, items, "?dry_run=maybe"), 400, "InvalidQuery");
}

TEST_CASE("import: a dry run of what is right says so, and the same goes in afterwards") {
  FreshServer fresh;
  const std::string flight = FlightWithoutCamera(fresh.client);
  auto items = Images();
  items.push_back(Beside("geo.txt", Geo(kNumImages - 1)));
  items.push_back(Beside("cameras.txt", kCameras));
  const auto dry = Post(fresh.client, flight, items, "?dry_run=true");
  REQUIRE(dry->status == 200);
  const nlohmann::json answer = nlohmann::json::parse(dry->body);
  CHECK(answer["would_be_refused"] == false);
  CHECK(answer["num_accepted"] == kNumImages - 1);
  CHECK(answer["images_without_pose"] == nlohmann::json{NameOf(kNumImages - 1)});
  CHECK(answer["camera"]["width_px"] == 320);
  CHECK(FrameList(fresh.client, flight).empty());
  CHECK(Post(fresh.client, flight, items)->status == 202);
}

TEST_CASE("import: a flight goes in several batches with the same poses, where that is asked for") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto batch = [](const std::vector<int>& images, int num_poses) {
    httplib::MultipartFormDataItems items{Beside("geo.txt", Geo(num_poses))};
    for (const int i : images) items.push_back(Images()[i]);
    return items;
  };
  CheckProblem(Post(fresh.client, flight, batch({0, 1}, kNumImages)), 422, "UnknownImages");
  const auto first = Post(fresh.client, flight, batch({0, 1}, kNumImages - 1), "?extra_poses=true");
  INFO(first->body);
  REQUIRE(first->status == 202);
  const nlohmann::json detail = nlohmann::json::parse(first->body)["detail"];
  CHECK(detail["num_poses"] == kNumImages - 1);
  CHECK(detail["num_images_without_pose"] == 0);
  const nlohmann::json before = FrameList(fresh.client, flight);

  // Of images that are there already, poses change nothing; the last image has none.
  const auto rest = Post(fresh.client, flight, batch({2, 3}, kNumImages - 1), "?extra_poses=true");
  REQUIRE(rest->status == 202);
  const nlohmann::json job =
      AwaitJob(fresh.client, nlohmann::json::parse(rest->body)["id"])["detail"];
  CHECK(job["num_accepted"] == 1);
  CHECK(job["num_images_without_pose"] == 1);
  CHECK(job["images"][1]["code"] == "NoPosition");
  const nlohmann::json after = FrameList(fresh.client, flight);
  CHECK(after.size() == kNumImages - 1);
  for (size_t i = 0; i < before.size(); ++i) CHECK(after[i]["sha256"] == before[i]["sha256"]);
}

TEST_CASE("import: a dry run names the formats also of files that cannot be used") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  auto items = Images();
  items.push_back(Beside("cameras.txt", kCameras));
  items.push_back(Beside("geo.txt", "EPSG:4326\n0.jpg 8 47\n"));
  const auto result = Post(fresh.client, flight, items, "?dry_run=true");
  REQUIRE(result->status == 200);
  const nlohmann::json answer = nlohmann::json::parse(result->body);
  CHECK(answer["problems"][0]["code"] == "InvalidPoses");
  REQUIRE(answer["formats"].size() == 2);
  CHECK(answer["formats"][0]["format"] == "colmap-cameras");
  CHECK(answer["formats"][1]["format"] == "odm-geo");
  CHECK(answer["formats"][1]["file"] == "geo.txt");
}

// A JPEG whose EXIF says nothing but a focal length of 27 mm on film of 36 mm.
std::string With27Mm(const std::string& jpeg) {
  const std::string exif(
      "Exif\0\0II*\0\x08\0\0\0"
      "\x01\0\x69\x87\x04\0\x01\0\0\0\x1A\0\0\0\0\0\0\0"
      "\x01\0\x05\xA4\x03\0\x01\0\0\0\x1B\0\0\0\0\0\0\0",
      50);
  const std::string segment = std::string("\xFF\xE1\0\x34", 4) + exif;
  return jpeg.substr(0, 2) + segment + jpeg.substr(2);
}

TEST_CASE("import: a dry run tells the camera that would be taken, of the images' tags too") {
  FreshServer fresh;
  const std::string flight = FlightWithoutCamera(fresh.client);
  auto items = Images();
  for (auto& item : items) item.content = With27Mm(item.content);
  items.push_back(Beside("geo.txt", Geo(kNumImages)));
  const auto camera_of = [&fresh, &items](const std::string& id) {
    const auto result = Post(fresh.client, id, items, "?dry_run=true");
    REQUIRE(result->status == 200);
    return nlohmann::json::parse(result->body)["camera"];
  };
  // 27 mm of 36 mm over 320 pixels.
  CHECK(camera_of(flight)["fx_px"] == 240.0);
  CHECK(camera_of(flight)["width_px"] == 320);
  items.push_back(Beside("cameras.txt", kCameras));
  CHECK(camera_of(flight)["fx_px"] == 300.0);
  CHECK(camera_of(flight)["cx_px"] == 159.5);
  // The flight's own wins over both.
  CHECK(camera_of(NewFlight(fresh.client))["cx_px"] == 160.0);
}

TEST_CASE("import: a file that cannot be read is told of with its line") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  auto items = Images();
  items.push_back(Beside("geo.txt", "EPSG:4326\n0.jpg 8 47\n"));
  const auto result = Post(fresh.client, flight, items);
  CheckProblem(result, 422, "InvalidPoses");
  CHECK(nlohmann::json::parse(result->body)["errors"][0]["pointer"] == "/poses/2/altitude_m");
}

}  // namespace
}  // namespace freelsd
