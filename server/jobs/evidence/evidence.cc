#include "server/jobs/evidence/evidence.h"

#include <nlohmann/json.hpp>

#include "api/import/import.h"

namespace freelsd {

std::string InputsDigest(const Storage& storage, const EvaluationInputs& inputs) {
  nlohmann::json text{{"version", FREELSD_VERSION},
                      {"model", inputs.model_digest},
                      {"flight", inputs.request.canonical_json},
                      {"origin", GeoPointJson(inputs.origin)},
                      {"frames", nlohmann::json::array()}};
  for (const FrameRow& frame : storage.frames.List(inputs.flight_id)) {
    if (frame.sequence > inputs.through_sequence) break;
    text["frames"].push_back({frame.id, frame.sha256, frame.resolved_json});
  }
  return Sha256Hex(text.dump());
}

std::string EvidenceDigest(const std::string& inputs_digest,
                           const std::string& map_digest,
                           const std::string& name_within_flight,
                           nlohmann::json feature,
                           const std::string& approach_json) {
  for (const char* const key : {"id", "flight_id", "updated_at", "last_seen_at"}) {
    feature["properties"].erase(key);
  }
  feature.erase("id");
  const nlohmann::json text{{"inputs", inputs_digest},
                            {"map", map_digest},
                            {"site", name_within_flight},
                            {"feature", feature},
                            {"approach", approach_json}};
  return Sha256Hex(text.dump());
}

}  // namespace freelsd
