// Which of two rows of the same thing is later, the same on all servers and in any order of
// arrival.
#pragma once

#include <optional>
#include <string>
#include <tuple>

#include <nlohmann/json.hpp>

#include "storage/storage.h"

namespace freelsd {

enum class Choice {
  kTake,  // what was told is later
  kSame,
  kKeep  // what is stored is later
};

inline std::string EvidenceDigestOf(const SiteRow& site) {
  const nlohmann::json feature = nlohmann::json::parse(site.feature_json, nullptr, false);
  if (!feature.is_object()) return {};
  return feature.value(nlohmann::json::json_pointer("/properties/evidence_digest"), std::string());
}

// The same text for the same values.
inline std::string Canonical(const std::string& json) {
  return json.empty() ? json : nlohmann::json::parse(json).dump();
}

inline auto RankOf(const SiteRow& site) {
  return std::tuple(site.updated_at_us,
                    site.seen_at_us,
                    EvidenceDigestOf(site),
                    Canonical(site.feature_json),
                    Canonical(site.approach_json),
                    Canonical(site.replan_json),
                    site.map_id);
}

inline auto RankOf(const ObstacleRow& obstacle) {
  return std::tuple(obstacle.updated_at_us, Canonical(obstacle.feature_json));
}

inline auto RankOf(const FlightMapRow& map) { return std::tuple(map.updated_at_us); }

template <typename Row>
Choice Between(const Row& told, const std::optional<Row>& stored) {
  if (!stored) return Choice::kTake;
  const auto told_rank = RankOf(told), stored_rank = RankOf(*stored);
  if (told_rank == stored_rank) return Choice::kSame;
  return stored_rank < told_rank ? Choice::kTake : Choice::kKeep;
}

}  // namespace freelsd
