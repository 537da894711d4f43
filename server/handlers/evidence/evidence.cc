#include "server/handlers/evidence/evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "api/api.h"
#include "engine/heights/heights.h"
#include "engine/provenance/provenance.h"
#include "server/intake/intake.h"

namespace freelsd {
namespace {

// Ground that a patch shows.
constexpr double kPatchM = 12.0;
// Heights are searched on the map this far around the place.
constexpr double kHeightsReachM = 15.0;
constexpr size_t kNumLikelihoodViews = 8;

// As it was adjusted. The groups of its views are not stored: all count as one.
AdjustedBlock BlockOf(const MapHead& head) {
  AdjustedBlock block;
  block.camera = head.camera;
  block.is_usable = true;
  for (const MapView& view : head.views) {
    AdjustedView adjusted;
    adjusted.frame_id = view.frame_id;
    adjusted.world_from_camera = view.world_from_camera;
    adjusted.readout = view.readout;
    adjusted.height_above_ground = view.height_above_ground;
    adjusted.is_connected = true;
    adjusted.group = 0;
    block.views.push_back(std::move(adjusted));
  }
  return block;
}

std::vector<StereoPair> PairsOf(const MapHead& head) {
  std::vector<StereoPair> pairs;
  for (size_t view = 0; view < head.views.size(); ++view) {
    for (const size_t partner : head.views[view].partners) pairs.push_back({view, partner, 0.0});
  }
  return pairs;
}

double PatchSidePx(const AdjustedBlock& block, const CellOnMap& cell, size_t view) {
  const double height = block.views[view].world_from_camera.translation.z() - cell.height;
  const double pixel_m = std::max(1.0, height) / block.camera.MeanFocalPx();
  return std::clamp(std::round(kPatchM / pixel_m), 16.0, 512.0);
}

double Thousandths(double value) { return std::round(1000.0 * value) / 1000.0; }

double TenthOf(double value) { return std::round(10.0 * value) / 10.0; }

nlohmann::json PatchJson(const CellOnMap& cell,
                         const AdjustedBlock& block,
                         const SourceView& source) {
  const std::string& frame_id = block.views[source.view].frame_id;
  const auto number = [](double value) { return nlohmann::json(value).dump(); };
  const double x_px = TenthOf(source.pixel.x()), y_px = TenthOf(source.pixel.y());
  const double side_px = PatchSidePx(block, cell, source.view);
  return {{"frame_id", frame_id},
          {"x_px", x_px},
          {"y_px", y_px},
          {"weight", Thousandths(source.weight)},
          {"url",
           "/v1/flights/" + cell.map.row.flight_id + "/frames/" + frame_id + "/patch.png?x_px=" +
               number(x_px) + "&y_px=" + number(y_px) + "&side_px=" + number(side_px)}};
}

MapRasters AroundCell(const Service& service, const CellOnMap& cell, double reach_m) {
  const Grid& grid = cell.map.head.grid;
  const cv::Rect cells = grid.CellsAround({cell.place_in_world}, reach_m) &
                         cv::Rect(0, 0, grid.num_cols, grid.num_rows);
  return service.maps.flight_maps().Read(
      service.storage, cell.map, 0, grid.Part(cells), TileLayers::kWithCues);
}

// The views that say most about the place's height: more photographs would only take longer.
AdjustedBlock MostWeighty(AdjustedBlock block, const std::vector<SourceView>& sources) {
  for (AdjustedView& view : block.views) view.is_connected = false;
  const size_t num = std::min(sources.size(), kNumLikelihoodViews);
  for (size_t i = 0; i < num; ++i) block.views[sources[i].view].is_connected = true;
  return block;
}

nlohmann::json LikelihoodJson(Service& service,
                              const CellOnMap& cell,
                              const AdjustedBlock& block,
                              const ElevationMap& around) {
  std::optional<HeightLikelihood> found;
  try {
    found = HeightLikelihoodAt(
        cell.place_in_world, around, block, StoredImages(service.intake, cell.map.row.flight_id));
  } catch (const ApiError&) {
    return nullptr;
  }
  if (!found) return nullptr;
  nlohmann::json heights_m = nlohmann::json::array(), likelihood = nlohmann::json::array();
  for (size_t i = 0; i < found->heights.size(); ++i) {
    const Eigen::Vector3d at(cell.place_in_world.x(), cell.place_in_world.y(), found->heights[i]);
    heights_m.push_back(Thousandths(cell.map.local_frame.GeoFromWorld(at).altitude_m));
    likelihood.push_back(Thousandths(found->log_likelihood[i]));
  }
  return {{"height_m", heights_m},
          {"log_likelihood", likelihood},
          {"num_views", found->num_views},
          {"baseline_ratio", Thousandths(found->baseline_ratio)},
          {"correlation", Thousandths(found->correlation)}};
}

nlohmann::json CueJson(const std::string& name, int8_t step) {
  nlohmann::json cue{{"cue", name}, {"log_odds", nullptr}, {"denies", step == CueSteps::kVeto}};
  if (step != CueSteps::kVeto && step != CueSteps::kUnknown) {
    cue["log_odds"] = Thousandths(static_cast<double>(step) * CueSteps::kLogOdds);
  }
  return cue;
}

// What denies grass first, then by size.
nlohmann::json CuesJson(const MapRasters& around, const cv::Point& cell) {
  if (around.cues.empty()) return nullptr;
  std::vector<std::pair<float, const CueLayer*>> order;
  order.reserve(around.cues.size());
  for (const CueLayer& cue : around.cues) {
    const auto step = static_cast<float>(cue.steps(cell));
    order.emplace_back(step == CueSteps::kUnknown ? 0.0f : -std::abs(step), &cue);
  }
  std::stable_sort(
      order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  nlohmann::json cues = nlohmann::json::array();
  for (const auto& [size, cue] : order) cues.push_back(CueJson(cue->name, cue->steps(cell)));
  return cues;
}

}  // namespace

nlohmann::json CellEvidenceJson(Service& service, const CellOnMap& cell) {
  const MapHead& head = cell.map.head;
  const AdjustedBlock block = BlockOf(head);
  const std::vector<StereoPair> pairs = PairsOf(head);
  const Eigen::Vector3d place(cell.place_in_world.x(), cell.place_in_world.y(), cell.height);
  const Provenance provenance = ProvenanceOf(place, block, pairs, {});
  nlohmann::json evidence{{"frames", nlohmann::json::array()},
                          {"patches", nlohmann::json::array()},
                          {"context_frames", nullptr}};
  for (const SourceView& source : provenance.sources) {
    evidence["frames"].push_back(block.views[source.view].frame_id);
    evidence["patches"].push_back(PatchJson(cell, block, source));
  }
  if (!pairs.empty()) {
    evidence["context_frames"] = nlohmann::json::array();
    for (const size_t view : provenance.context) {
      evidence["context_frames"].push_back(block.views[view].frame_id);
    }
  }
  const MapRasters around = AroundCell(service, cell, kHeightsReachM);
  const auto at = around.site_map.map.grid.CellAt(cell.place_in_world);
  evidence["cues"] = at ? CuesJson(around, *at) : nlohmann::json(nullptr);
  evidence["height_likelihood"] =
      LikelihoodJson(service, cell, MostWeighty(block, provenance.sources), around.site_map.map);
  return evidence;
}

nlohmann::json NearestLimitJson(const PlaceJudgement& judgement, const Aircraft& aircraft) {
  if (!judgement.plan || !judgement.plan->risk) return nullptr;
  const LandingRisk& risk = *judgement.plan->risk;
  const std::array<std::pair<const char*, double>, 5> parts{{{"ground", risk.parts.ground},
                                                             {"final", risk.parts.final_path},
                                                             {"circle", risk.parts.circle},
                                                             {"position", risk.parts.position},
                                                             {"wind", risk.parts.wind}}};
  const auto most = std::max_element(
      parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const double limit = aircraft.max_failure_probability;
  return {{"part", most->first},
          {"value", Thousandths(most->second)},
          {"limit", Thousandths(limit)},
          {"margin", Thousandths(limit - most->second)},
          {"whole", Thousandths(risk.failure_probability)}};
}

nlohmann::json OptionsOfMapJson(const MapHead& head) {
  return GivenOptionsJson(ParseStoredFlightRequest(head.flight_json));
}

nlohmann::json VersionsOfMapJson(const FlightMap& map) {
  return {{"program", map.head.program_version},
          {"grass_model_sha256", map.head.model_sha256},
          {"map", map.row.id},
          {"evaluated_at", Rfc3339(map.row.updated_at_us)}};
}

}  // namespace freelsd
