// A small rendered flight that yields regions and sites, and the calls to submit it.
#pragma once

#include "tests/server/test_server.h"

namespace freelsd {

constexpr int kNumSampleFrames = 24;

// The model that is delivered.
std::filesystem::path RealModel();
// Flight without frames, `options` and `aircraft` added to its request; its id.
std::string NewSampleFlight(httplib::Client& client,
                            const nlohmann::json& options = {},
                            const nlohmann::json& aircraft = {});
// Flight with its frames [begin, end) as one batch; its id.
std::string PostSampleFlight(httplib::Client& client, int begin, int end);
// `prefix`: of the frames' ids, to send the same frames again.
void PostSampleFrames(httplib::Client& client,
                      const std::string& flight,
                      int begin,
                      int end,
                      const std::string& prefix = "");
// The whole flight; its request gives no datum, but the column of its altitudes is alt_amsl_m. Its
// aircraft needs a strip of 2 km, so all its sites are rejected.
std::string PostSampleFlightWithNamedDatum(httplib::Client& client);
// The file of poses of these frames, as a batch of them has it.
std::string SamplePoses(int begin, int end, const std::string& prefix = "");
// POST finish; the job's id.
std::string Finish(httplib::Client& client, const std::string& flight);
// Whether the job is seen running in the backend.
bool AwaitEvaluation(httplib::Client& client, const std::string& job);
nlohmann::json SiteIds(httplib::Client& client, const std::string& flight);

}  // namespace freelsd
