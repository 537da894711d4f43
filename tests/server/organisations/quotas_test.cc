// Quotas of organisations, across two servers on one database.
#include <string>

#include <doctest/doctest.h>

#include "tests/server/organisations/two_organisations.h"

namespace freelsd {
namespace {

struct SouthWith {
  explicit SouthWith(const Quotas& quotas)
      : two([&](Config& config) { config.organisations["south"].quotas = quotas; }),
        south(two.storage->ForOrganisation("south")),
        client(two.As("south")),
        flight(NewFlight(client)) {}

  httplib::Result Put(int number) {
    return PutFrame(
        client, flight, "f" + std::to_string(number), NoiseImage(number), SomeMeta(number));
  }
  size_t NumFrames() { return FrameList(client, flight).size(); }
  uint64_t NumBytes() const { return south->images.NumBytes(); }

  TwoOrganisations two;
  // Opened before the server stores anything, because an opening removes what is unused.
  std::unique_ptr<Storage> south;
  httplib::Client client;
  std::string flight;
};

TEST_SUITE("postgresql" * doctest::skip()) {
  TEST_CASE("quotas: frames of a minute, then 429 with Retry-After, and nothing is stored") {
    Quotas quotas;
    quotas.max_frames_per_minute = 3.0;
    SouthWith south(quotas);
    for (int i = 0; i < 3; ++i) CHECK(south.Put(i)->status == 201);
    const uint64_t num_bytes = south.NumBytes();
    const auto refused = south.Put(3);
    CheckProblem(refused, 429, "FrameQuota");
    CHECK(refused->has_header("Retry-After"));
    CHECK(south.NumFrames() == 3);
    CHECK(south.NumBytes() == num_bytes);
    // A frame that is stored costs nothing again.
    CHECK(south.Put(2)->status == 200);
    // Another process counts in the same row; another organisation has its own.
    CHECK(south.south->quotas.Admit(quotas, {0, 1, 0}));
    CHECK_FALSE(south.two.north->quotas.Admit(quotas, {0, 1, 0}));
  }

  TEST_CASE("quotas: bytes of images, then 507, and nothing is stored") {
    Quotas quotas;
    quotas.max_num_image_bytes = static_cast<int64_t>(NoiseImage(0).size() * 5 / 2);
    SouthWith south(quotas);
    CHECK(south.Put(0)->status == 201);
    CHECK(south.Put(1)->status == 201);
    const uint64_t num_bytes = south.NumBytes();
    CheckProblem(south.Put(2), 507, "ByteQuota");
    httplib::MultipartFormDataItems batch{{"images", NoiseImage(4), "a.jpg", "image/jpeg"}};
    CheckProblem(
        south.client.Post("/v1/flights/" + south.flight + "/batch", batch), 507, "ByteQuota");
    CHECK(south.NumFrames() == 2);
    CHECK(south.NumBytes() == num_bytes);
    // What is deleted counts no longer.
    CHECK(south.client.Delete("/v1/flights/" + south.flight)->status == 204);
    CHECK(south.NumBytes() == 0);
    south.flight = NewFlight(south.client);
    CHECK(south.Put(2)->status == 201);
  }

  TEST_CASE("quotas: unfinished jobs, then 429, and no job and no image is stored") {
    Quotas quotas;
    quotas.max_num_unfinished_jobs = 1;
    SouthWith south(quotas);
    CHECK(south.Put(0)->status == 201);
    const uint64_t num_bytes = south.NumBytes();
    const std::string path = "/v1/flights/" + south.flight;
    CHECK(south.client.Post(path + "/finish")->status == 202);
    // The same finish again is the same job.
    CHECK(south.client.Post(path + "/finish")->status == 202);
    httplib::MultipartFormDataItems batch{{"images", NoiseImage(5), "a.jpg", "image/jpeg"}};
    const auto refused = south.client.Post(path + "/batch", batch);
    CheckProblem(refused, 429, "JobQuota");
    CHECK(refused->has_header("Retry-After"));
    CHECK(south.NumBytes() == num_bytes);
    CHECK(GetJson(south.client, "/v1/jobs").at("jobs").size() == 1);
  }
}

}  // namespace
}  // namespace freelsd
