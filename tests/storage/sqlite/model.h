// A plain model of what a storage must hold.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

#include <doctest/doctest.h>

#include "storage/storage.h"

namespace freelsd {

// Their ids are f0, f1, ...
constexpr int kNumModelFlights = 6;

// What the client was promised. Values are versions of the rows.
struct Model {
  std::map<std::string, std::string> obstacles;
  std::map<std::string, std::string> sites;
  // Ids of superseded sites.
  std::set<std::string> superseded;
  // The tile of each map in force.
  std::map<std::string, std::string> maps;
  std::set<std::string> flights;
  std::map<std::string, std::string> frames;

  bool operator==(const Model&) const = default;
};

// As emergency recall sees it, and as lists do: both must tell the same.
inline Model Stored(const Storage& storage) {
  Model model;
  for (const ObstacleRow& row : storage.obstacles.List()) {
    model.obstacles[row.id] = row.feature_json;
  }
  std::set<std::string> recalled;
  for (const auto& row : storage.sites.ListRecallable({-180.0, -90.0, 180.0, 90.0}))
    recalled.insert(row->site_id);
  for (const SiteRow& row : storage.sites.List(std::nullopt, std::nullopt)) {
    model.sites[row.id] = row.feature_json;
    if (row.superseded_by) model.superseded.insert(row.id);
    CHECK(recalled.contains(row.id) != row.superseded_by.has_value());
  }
  for (int i = 0; i < kNumModelFlights; ++i) {
    for (const auto& map : storage.maps.ListOf("f" + std::to_string(i))) {
      const auto tile = storage.maps.ReadTile(map.id, {0, 0, 0});
      REQUIRE(tile);
      CHECK(storage.maps.ReadTileCopy(map.id, {0, 0, 0}) == tile);
      model.maps[map.id] = *tile;
    }
  }
  for (const FlightRow& flight : storage.flights.List()) {
    model.flights.insert(flight.id);
    for (const FrameRow& frame : storage.frames.List(flight.id)) {
      model.frames[flight.id + "/" + frame.id] = frame.meta_json;
    }
  }
  return model;
}

constexpr size_t kToldBytes = 8;

inline std::string ToldOf(const Model& model) {
  std::string told;
  for (const auto& [id, text] : model.obstacles)
    told += " " + id + "=" + text.substr(0, kToldBytes);
  for (const auto& [id, text] : model.sites) {
    told +=
        " " + id + "=" + text.substr(0, kToldBytes) + (model.superseded.contains(id) ? "!" : "");
  }
  for (const auto& [id, tile] : model.maps) told += " " + id + "=" + tile.substr(0, kToldBytes);
  for (const std::string& id : model.flights) told += " " + id;
  for (const auto& [id, text] : model.frames) told += " " + id + "=" + text.substr(0, kToldBytes);
  return told;
}

}  // namespace freelsd
