// Which flights are in memory when there are more than may be.
#include "server/jobs/open_flights.h"

#include <fstream>
#include <iterator>

#include <doctest/doctest.h>

#include "tests/server/test_server.h"
#include "tests/synthetic/flight_files.h"

namespace freelsd {
namespace {

OpenFlights::SessionPointer SomeSession() {
  std::ifstream file(TestModel(), std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  FlightRig flight_rig;
  flight_rig.rig.camera = PaperCamera(320, 240);
  FlightRow flight;
  flight.id = std::string("f");
  flight.request_json = ParseFlightRequest(R"({"name":"x"})").canonical_json;
  flight.rig_json = FlightRigJson(flight_rig);
  const GroundModel ground_model = Classifier::Parse(text);
  return std::make_shared<FlightSession>(flight, GroundModels{ground_model, ground_model});
}

TEST_CASE(
    "open flights: of those that wait for room the longest waiting is next, whatever its id") {
  const TemporaryFolder folder;
  const Storage storage(StorageAt(folder.path()));
  const OpenFlights::SessionPointer session = SomeSession();
  OpenFlights flights(storage, 1);
  REQUIRE(flights.MayOpen("m"));
  flights.Open("m", session);
  CHECK(flights.MayOpen("m"));
  CHECK_FALSE(flights.MayOpen("z"));
  CHECK_FALSE(flights.MayOpen("a"));
  flights.Close("m");
  CHECK_FALSE(flights.MayOpen("a"));
  CHECK_FALSE(flights.MayOpen("m"));
  REQUIRE(flights.MayOpen("z"));
  flights.Open("z", session);
  // The work of the two others was deleted meanwhile.
  CHECK_FALSE(flights.MayOpen("b"));
  CHECK(flights.CloseIdle({"z", "b"}, {"z"}).empty());
  flights.Close("z");
  CHECK(flights.MayOpen("b"));
}

TEST_CASE("flight session: a result that could not be stored is the first of the next call") {
  const OpenFlights::SessionPointer session = SomeSession();
  std::vector<std::string> stored;
  const auto store = [&stored](const FrameResult& result) {
    if (result.frame_id == "b" && stored.size() == 1) {
      stored.emplace_back("failed");
      throw StorageError("write", "the database is out of reach");
    }
    stored.push_back(result.frame_id);
  };
  CHECK_THROWS_AS(session->StoreResults({{"a", true, ""}, {"b", true, ""}, {"c", true, ""}}, store),
                  StorageError);
  CHECK(session->HasUnstoredResults());
  session->StoreResults({{"d", true, ""}}, store);
  CHECK(stored == std::vector<std::string>{"a", "failed", "b", "c", "d"});
  CHECK_FALSE(session->HasUnstoredResults());
}

}  // namespace
}  // namespace freelsd
