// What a site's evidence_digest is made of. Equal digests mean: the same program with the same
// model made the same map and the same plan from the same photographs, poses and options.
#pragma once

#include <cstdint>
#include <string>

#include "api/api.h"
#include "storage/storage.h"

namespace freelsd {

// What an evaluation of a flight starts from, besides its photographs.
struct EvaluationInputs {
  std::string flight_id;
  // Of the last frame that the engine has got.
  int64_t through_sequence = 0;
  // With the datum of all altitudes.
  const FlightRequest& request;
  GeoPoint origin;
  // SHA-256 of the grass model's file.
  const std::string& model_digest;
};

// SHA-256 over the program's version, the model, the flight's request and origin, and each
// frame's id, image digest and the metadata that the engine used, in the order of processing.
std::string InputsDigest(const Storage& storage, const EvaluationInputs& inputs);

// SHA-256 over the inputs, the tiles of the site's map, and the site's place on the map and plan.
// Ids of flights and times of the evaluation do not count. `feature` is the stored one.
std::string EvidenceDigest(const std::string& inputs_digest,
                           const std::string& map_digest,
                           const std::string& name_within_flight,
                           nlohmann::json feature,
                           const std::string& approach_json);

}  // namespace freelsd
