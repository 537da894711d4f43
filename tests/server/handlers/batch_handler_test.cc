// Many images at once.
#include <algorithm>
#include <filesystem>
#include <map>

#include <archive.h>
#include <archive_entry.h>
#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

constexpr char kPosesHeader[] = "image,latitude_deg,longitude_deg,altitude_m,timestamp_us\n";

std::string PoseLine(const std::string& image, int number) {
  return image + ",47.000" + std::to_string(number) + ",8.0,500," +
         std::to_string(1700000000000000 + int64_t{1000000} * number) + "\n";
}

httplib::MultipartFormData Image(const std::string& name, const std::string& bytes) {
  return {"images", bytes, name, "image/jpeg"};
}

httplib::Result PostBatch(httplib::Client& client,
                          const std::string& flight,
                          const httplib::MultipartFormDataItems& items) {
  return client.Post("/v1/flights/" + flight + "/batch", items);
}

nlohmann::json VerdictOf(const nlohmann::json& job, const std::string& id) {
  for (const nlohmann::json& image : job["detail"]["images"]) {
    if (image["id"] == id) return image;
  }
  return {};
}

// A zip archive in memory.
std::string Zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string bytes(size_t{4} << 20, '\0');
  size_t size = 0;
  archive* const written = archive_write_new();
  archive_write_set_format_zip(written);
  archive_write_open_memory(written, bytes.data(), bytes.size(), &size);
  for (const auto& [name, content] : files) {
    archive_entry* const header = archive_entry_new();
    archive_entry_set_pathname(header, name.c_str());
    archive_entry_set_filetype(header, AE_IFREG);
    archive_entry_set_perm(header, 0644);
    archive_entry_set_size(header, static_cast<la_int64_t>(content.size()));
    archive_write_header(written, header);
    archive_write_data(written, content.data(), content.size());
    archive_entry_free(header);
  }
  archive_write_close(written);
  archive_write_free(written);
  return bytes.substr(0, size);
}

TEST_CASE("batch: a zip archive of images and poses is taken as a multipart body is") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string poses = kPosesHeader + PoseLine("b.jpg", 2) + PoseLine("a.jpg", 1);
  const std::string zip = Zip({{"flight/b.jpg", NoiseImage(2)},
                               {"flight/poses.csv", poses},
                               {"flight/a.jpg", NoiseImage(1)},
                               {"flight/cut.jpg", NoiseImage(3).substr(0, 9000)}});
  for (const char* type : {"application/zip", "application/octet-stream", ""}) {
    const auto result = fresh.client.Post("/v1/flights/" + flight + "/batch", zip, type);
    REQUIRE(result);
    INFO(result->body);
    REQUIRE(result->status == 202);
    const nlohmann::json job = AwaitJob(fresh.client, nlohmann::json::parse(result->body)["id"]);
    CHECK(job["state"] == "done");
    CHECK(VerdictOf(job, "a.jpg")["verdict"] == "accepted");
    CHECK(VerdictOf(job, "b.jpg")["verdict"] == "accepted");
    CHECK(VerdictOf(job, "cut.jpg")["code"] == "DamagedImage");
  }
  const nlohmann::json frames = FrameList(fresh.client, flight);
  REQUIRE(frames.size() == 2);
  CHECK(frames[0]["id"] == "a.jpg");
  CHECK(std::filesystem::is_empty(fresh.folder.path() / "data/spool"));
}

bool Tells(const nlohmann::json& warnings, const std::string& sentence) {
  return std::find(warnings.begin(), warnings.end(), sentence) != warnings.end();
}

TEST_CASE("batch: what is no image in a project's zip is left aside and told of") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string zip =
      Zip({{"README.md", "# A flight"},
           {"code/README.md", "# How"},
           {"LICENSE", "as you like"},
           {"odm_orthophoto/odm_orthophoto.tif", "II*"},
           {"task_output.txt", "[INFO] running, all is well\n"},
           {"images/a.jpg", NoiseImage(1)},
           {"images/without_extension", NoiseImage(2)},
           {"gcp_list.txt", "EPSG:4326\n8 47 400 10 20 a.jpg gcp1\n"},
           {"geo.txt", "EPSG:4326\na.jpg 8 47 500\nwithout_extension 8 47 500\n"}});
  const std::string path = "/v1/flights/" + flight + "/batch";
  const auto result = fresh.client.Post(path, zip, "application/zip");
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 202);
  const nlohmann::json detail = nlohmann::json::parse(result->body)["detail"];
  CHECK(detail["num_accepted"] == 2);
  CHECK(detail["num_rejected"] == 0);
  const nlohmann::json& warnings = detail["warnings"];
  const std::string other = ": neither an image (JPEG, PNG) nor a file of a known format, ignored";
  for (const char* const name : {"README.md",
                                 "code/README.md",
                                 "LICENSE",
                                 "odm_orthophoto/odm_orthophoto.tif",
                                 "task_output.txt"}) {
    CHECK(Tells(warnings, name + other));
  }
  CHECK(Tells(warnings, "gcp_list.txt: ground control points are not used"));
  std::map<std::string, std::string> formats;
  for (const auto& format : detail["formats"]) formats[format["file"]] = format["format"];
  CHECK(formats["gcp_list.txt"] == "odm-gcp");
  CHECK(formats["geo.txt"] == "odm-geo");
  CHECK(formats["LICENSE"] == "unknown");
  CheckProblem(
      fresh.client.Post(path, Zip({{"a.tif", "II*"}}), "application/zip"), 422, "MissingPart");
}

TEST_CASE(
    "batch: an empty file beside the images is told of, and refused where there is nothing else") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/batch";
  const auto alone = fresh.client.Post(path, Zip({{"poses.csv", ""}}), "application/zip");
  CheckProblem(alone, 422, "InvalidPoses");
  CHECK(nlohmann::json::parse(alone->body)["errors"][0]["pointer"] == "/poses/poses.csv");
  const auto result = fresh.client.Post(path,
                                        Zip({{"a.jpg", NoiseImage(1)},
                                             {"markers.csv", ""},
                                             {"project.json", ""},
                                             {"geo.txt", "EPSG:4326\na.jpg 8 47 500\n"}}),
                                        "application/zip");
  REQUIRE(result->status == 202);
  const nlohmann::json detail = nlohmann::json::parse(result->body)["detail"];
  CHECK(detail["num_accepted"] == 1);
  CHECK(Tells(detail["warnings"], "markers.csv: the file is empty, ignored"));
  CHECK(Tells(detail["warnings"], "project.json: the file is empty, ignored"));
}

TEST_CASE("batch: what is sent as an image and is none is refused as one") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto result =
      PostBatch(fresh.client, flight, {Image("a.tif", "II*"), Image("b.jpg", NoiseImage(1))});
  REQUIRE(result->status == 202);
  const nlohmann::json job = nlohmann::json::parse(result->body);
  CHECK(VerdictOf(job, "a.tif")["code"] == "UnsupportedImage");
  CHECK(job["detail"]["num_rejected"] == 2);  // b.jpg has no pose
}

TEST_CASE("batch: a zip that is cut or names a place outside is refused and stores nothing") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string path = "/v1/flights/" + flight + "/batch";
  const std::string zip = Zip({{"a.jpg", NoiseImage(1)}});
  const auto cut = fresh.client.Post(path, zip.substr(0, zip.size() / 2), "application/zip");
  CheckProblem(cut, 422, "ZipRefused");
  const auto slip =
      fresh.client.Post(path, Zip({{"../../a.jpg", NoiseImage(1)}}), "application/zip");
  CheckProblem(slip, 422, "ZipRefused");
  CHECK(FrameList(fresh.client, flight).empty());
  CHECK(std::filesystem::is_empty(fresh.folder.path() / "data/spool"));
}

TEST_CASE("batch: good images go on, damaged ones and ones without pose are told of") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string poses =
      kPosesHeader + PoseLine("b.jpg", 2) + PoseLine("a.jpg", 1) + PoseLine("cut.jpg", 3);
  const auto result = PostBatch(fresh.client,
                                flight,
                                {Image("b.jpg", NoiseImage(2)),
                                 {"poses", poses, "poses.csv", "text/csv"},
                                 Image("cut.jpg", NoiseImage(3).substr(0, 9000)),
                                 Image("a.jpg", NoiseImage(1)),
                                 Image("lost.jpg", NoiseImage(4))});
  REQUIRE(result);
  INFO(result->body);
  REQUIRE(result->status == 202);
  const nlohmann::json job = AwaitJob(fresh.client, nlohmann::json::parse(result->body)["id"]);
  CHECK(job["state"] == "done");
  CHECK(VerdictOf(job, "a.jpg")["verdict"] == "accepted");
  CHECK(VerdictOf(job, "b.jpg")["verdict"] == "accepted");
  CHECK(VerdictOf(job, "cut.jpg")["code"] == "DamagedImage");
  CHECK(VerdictOf(job, "lost.jpg")["code"] == "NoPosition");
  const nlohmann::json frames = FrameList(fresh.client, flight);
  REQUIRE(frames.size() == 2);
  // In the order of time, not of arrival.
  CHECK(frames[0]["id"] == "a.jpg");
  CHECK(frames[0]["state"] != "queued");
  const nlohmann::json told = GetJson(fresh.client, "/v1/flights/" + flight);
  CHECK(told["frames"]["received"] == 2);
  CHECK(told["frames"]["processed"] == 2);
  // Two on arrival, and two that only show noise.
  CHECK(told["frames"]["rejected"] == 4);
}

TEST_CASE("batch: where no photograph is accepted, the answer says so and nothing is queued") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const auto result =
      PostBatch(fresh.client,
                flight,
                {Image("a.jpg", NoiseImage(1).substr(0, 9000)), Image("b.jpg", NoiseImage(2))});
  REQUIRE(result);
  REQUIRE(result->status == 202);
  const nlohmann::json job = nlohmann::json::parse(result->body);
  CHECK(job["state"] == "done");
  CHECK(job["progress"] == 1.0);
  CHECK(job["detail"]["num_accepted"] == 0);
  CHECK(job["detail"]["message"].get<std::string>().find("no photograph was accepted") == 0);
  CHECK(GetJson(fresh.client, "/v1/jobs/" + job["id"].get<std::string>()) == job);
  CHECK(GetJson(fresh.client, "/v1/flights/" + flight)["frames"]["rejected"] == 2);
}

TEST_CASE("batch: the same batch again changes nothing") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const httplib::MultipartFormDataItems items{
      Image("a.jpg", NoiseImage(1)), {"poses", kPosesHeader + PoseLine("a.jpg", 1), "p.csv", ""}};
  CHECK(PostBatch(fresh.client, flight, items)->status == 202);
  const auto again = PostBatch(fresh.client, flight, items);
  REQUIRE(again->status == 202);
  const nlohmann::json job = AwaitJob(fresh.client, nlohmann::json::parse(again->body)["id"]);
  CHECK(job["state"] == "done");
  CHECK(VerdictOf(job, "a.jpg")["verdict"] == "accepted");
  CHECK(FrameList(fresh.client, flight).size() == 1);
}

TEST_CASE("batch: faults of structure are refused and store nothing") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string image = NoiseImage(1);
  const auto unknown = PostBatch(
      fresh.client,
      flight,
      {Image("a.jpg", image), {"poses", kPosesHeader + PoseLine("b.jpg", 1), "p.csv", ""}});
  CheckProblem(unknown, 422, "UnknownImages");
  CHECK(nlohmann::json::parse(unknown->body)["errors"][0]["pointer"] == "/poses/0/image");
  CheckProblem(
      PostBatch(fresh.client, flight, {Image("a.jpg", image), Image("a.jpg", NoiseImage(2))}),
      422,
      "DuplicateId");
  CheckProblem(
      PostBatch(fresh.client, flight, {{"pictures", image, "a.jpg", ""}}), 422, "UnknownPart");
  CheckProblem(
      fresh.client.Post("/v1/flights/" + flight + "/batch", "nothing of the kind", "text/plain"),
      415,
      "UnsupportedMediaType");
  CHECK(FrameList(fresh.client, flight).empty());
  CHECK(GetJson(fresh.client, "/v1/jobs")["jobs"].empty());
  const std::filesystem::path images = fresh.folder.path() / "data/images";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(images)) {
    CHECK_FALSE(entry.is_regular_file());
  }
}

TEST_CASE("batch: pose files count against one limit together, and each against its own") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const size_t max_bytes = kLimits.poses.max_file_bytes;
  const std::string image = NoiseImage(1);
  const std::string too_large(max_bytes + 1, '#');
  const auto one =
      PostBatch(fresh.client, flight, {Image("a.jpg", image), {"poses", too_large, "p.csv", ""}});
  CheckProblem(one, 413, "PosesTooLarge");
  CHECK(nlohmann::json::parse(one->body)["detail"] == "the pose file is larger than 64 MiB");
  const std::string largest(max_bytes, '#');
  const auto three = PostBatch(fresh.client,
                               flight,
                               {Image("a.jpg", image),
                                {"poses", largest, "p.csv", ""},
                                {"poses", largest, "q.csv", ""},
                                {"poses", "#", "r.csv", ""}});
  CheckProblem(three, 413, "PosesTooLarge");
  CHECK(nlohmann::json::parse(three->body)["detail"] ==
        "the files beside the images are together larger than 128 MiB");
  CHECK(FrameList(fresh.client, flight).empty());
}

TEST_CASE("batch: a body that ends within a part is refused") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string body =
      "--xyz\r\nContent-Disposition: form-data; name=\"images\"; filename=\"a.jpg\"\r\n\r\nabc";
  CheckProblem(fresh.client.Post(
                   "/v1/flights/" + flight + "/batch", body, "multipart/form-data; boundary=xyz"),
               400,
               "InvalidMultipart");
}

TEST_CASE("batch: more parts than the library's own parser takes are taken") {
  constexpr int kNumImages = 1100;
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  httplib::MultipartFormDataItems items;
  for (int i = 0; i < kNumImages; ++i) {
    items.push_back(Image("empty-" + std::to_string(i), "x"));
  }
  const auto result = PostBatch(fresh.client, flight, items);
  REQUIRE(result);
  REQUIRE(result->status == 202);
  CHECK(nlohmann::json::parse(result->body)["detail"]["num_rejected"] == kNumImages);
}

}  // namespace
}  // namespace freelsd
