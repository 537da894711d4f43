// Bad input gets a problem+json and changes nothing. One test each.
#include <doctest/doctest.h>

#include "tests/server/test_server.h"

namespace freelsd {
namespace {

// A flight with one stored frame; checks at the end that it is as it was.
struct StoredFlight {
  FreshServer fresh;
  std::string flight = NewFlight(fresh.client);
  std::string path = "/v1/flights/" + flight + "/frames/new";
  nlohmann::json before;

  StoredFlight() {
    PutFrame(fresh.client, flight, "stored", NoiseImage(1), SomeMeta());
    before = Ids();
  }
  ~StoredFlight() {
    CHECK(Ids() == before);
    CHECK(GetJson(fresh.client, "/v1/flights/" + flight)["frames"]["received"] == 1);
  }
  nlohmann::json Ids() {
    nlohmann::json ids;
    for (const auto& frame : FrameList(fresh.client, flight)) ids.push_back(frame["sha256"]);
    return ids;
  }
  httplib::Result Put(const std::string& image, const std::string& meta) {
    return PutFrame(fresh.client, flight, "new", image, meta);
  }
};

std::string MetaWith(const std::string& key, const std::string& value) {
  std::string meta = SomeMeta(1);
  const size_t at = meta.find("\"" + key + "\":") + key.size() + 3;
  return meta.replace(at, meta.find_first_of(",}", at) - at, value);
}

// First bytes of a JPEG that claims to be 30000 x 30000.
std::string HugeJpeg() {
  const unsigned char bytes[] = {0xff, 0xd8, 0xff, 0xc0, 0x00, 0x11, 0x08, 0x75, 0x30, 0x75, 0x30,
                                 0x03, 0x01, 0x22, 0x00, 0x02, 0x11, 0x01, 0x03, 0x11, 0x01};
  return std::string(reinterpret_cast<const char*>(bytes), sizeof(bytes)) + std::string(500, 'x');
}

TEST_CASE("bad input: a truncated JPEG is 422") {
  StoredFlight stored;
  const std::string image = NoiseImage(2);
  CheckProblem(stored.Put(image.substr(0, image.size() / 2), SomeMeta(1)), 422, "DamagedImage");
}

TEST_CASE("bad input: a good JPEG after a damaged one is taken") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  const std::string image = NoiseImage(2);
  for (int i = 0; i < 3; ++i) {
    const std::string id = std::to_string(i);
    CHECK(PutFrame(fresh.client, flight, id, image.substr(0, 5000), SomeMeta(i))->status == 422);
    CHECK(PutFrame(fresh.client, flight, id, image, SomeMeta(i))->status == 201);
  }
}

TEST_CASE("bad input: the header of a 30000x30000 image is 413 before anything is allocated") {
  StoredFlight stored;
  CheckProblem(stored.Put(HugeJpeg(), SomeMeta(1)), 413, "ImageTooLarge");
}

TEST_CASE("bad input: NaN in a pose is no JSON") {
  StoredFlight stored;
  CheckProblem(stored.Put(NoiseImage(2), MetaWith("latitude_deg", "NaN")), 400, "InvalidJson");
}

TEST_CASE(
    "bad input: a frame a hundred kilometres from the flight's others is rejected, told why") {
  FreshServer fresh;
  const std::string flight = NewFlight(fresh.client);
  PutFrame(fresh.client, flight, "here", NoiseImage(1), SomeMeta());
  const double latitude_deg =
      nlohmann::json::parse(SomeMeta(1))["position"]["latitude_deg"].get<double>() + 1.0;
  const std::string meta = MetaWith("latitude_deg", std::to_string(latitude_deg));
  CHECK(PutFrame(fresh.client, flight, "far", NoiseImage(2), meta)->status == 201);
  const auto finish = fresh.client.Post("/v1/flights/" + flight + "/finish");
  REQUIRE(AwaitJob(fresh.client, nlohmann::json::parse(finish->body)["id"])["state"] == "done");
  const nlohmann::json far = FrameList(fresh.client, flight)[1];
  CHECK(far["state"] == "rejected");
  CHECK(far["reason"] == "its position is 111 km from the flight's origin; the limit is 50 km");
}

TEST_CASE("bad input: a missing image part is 422") {
  StoredFlight stored;
  CheckProblem(
      stored.fresh.client.Put(stored.path, {{"meta", SomeMeta(1), "", "application/json"}}),
      422,
      "MissingPart");
}

TEST_CASE("bad input: an unknown key is 422 with its place") {
  StoredFlight stored;
  nlohmann::json meta = nlohmann::json::parse(SomeMeta(1));
  meta["colour"] = "green";
  const auto result = stored.Put(NoiseImage(2), meta.dump());
  CheckProblem(result, 422, "UnknownKey");
  CHECK(result->body.find("/colour") != std::string::npos);
}

TEST_CASE("bad input: a misspelt key is told, not only the key that is missing for it") {
  FreshServer fresh;
  for (const auto& [body, pointer] :
       {std::pair(R"({"nme":"field"})", "/nme"),
        std::pair(R"({"name":"x","origin":{"lattitude_deg":47,"longitude_deg":8,"altitude_m":1}})",
                  "/origin/lattitude_deg"),
        std::pair(R"({"name":"x","camera":{"width":640}})", "/camera/width")}) {
    const auto result = fresh.client.Post("/v1/flights", body, "application/json");
    CheckProblem(result, 422, "UnknownKey");
    CHECK(nlohmann::json::parse(result->body)["errors"][0]["pointer"] == pointer);
  }
}

}  // namespace
}  // namespace freelsd
