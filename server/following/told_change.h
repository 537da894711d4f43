// A change as servers tell it to each other, as JSON.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "storage/storage.h"

namespace freelsd {

struct ToldChange {
  // key, kind, stamp_us and origin.
  ChangeRow change;
  // It is not in the area any more. It was not removed.
  bool has_left = false;
  // What is stored; nothing of a removal.
  std::optional<SiteRow> site;
  // Without its head.
  std::optional<FlightMapRow> map;
  std::optional<ObstacleRow> obstacle;

  bool IsRemoval() const { return freelsd::IsRemoval(change.kind); }
};

// "site", "map" or "obstacle"; nothing if the word is another.
std::optional<ChangeSubject> SubjectOfWord(const std::string& word);
// What the change is about, as stored now. Nothing if it is stored no longer: its removal is told
// later.
std::optional<ToldChange> ReadTold(const Storage& storage, const ChangeRow& change);
// `feed` replaces an empty origin.
nlohmann::json ToldJson(const ToldChange& told, const std::string& feed);
// Throws ApiError; `pointer` is its place in the body.
ToldChange ParseTold(const nlohmann::json& object, const std::string& pointer);

}  // namespace freelsd
