// Input: a finished evaluation, a cell of its map. Output: whether the photographs that the cell's
// provenance names make the same cell again, alone, and another one without the most weighty.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "engine/ground_map.h"
#include "engine/provenance/provenance.h"
#include "tests/evaluation/engine_run.h"

namespace freelsd {

// What the map holds of a cell, layer by layer; NaN where unknown. Cues by name.
using CellLayers = std::map<std::string, double>;

struct CellProof {
  Eigen::Vector2d place_in_world = Eigen::Vector2d::Zero();
  size_t num_sources = 0;
  size_t num_context = 0;
  // Layers that differ from those of the whole map: by the named photographs, and without the most
  // weighty one.
  std::vector<std::string> changed;
  std::vector<std::string> changed_without;
  // Of those that show it.
  double largest_weight = 0.0;
};

// Makes cells of one evaluation again, with its poses held. Thread-safe.
class CellProver {
 public:
  // All must outlive it.
  CellProver(const EngineRun& run,
             const Aircraft& aircraft,
             const PipelineOptions& options,
             const ImageSource& images);

  // `cell` of the evaluation's map; its elevation is known.
  CellProof Prove(const cv::Point& cell, const ProvenanceOptions& provenance);

 private:
  CellLayers Again(const Eigen::Vector2d& place_in_world,
                   const std::vector<size_t>& views,
                   double context_m);
  std::vector<Points> PointsOf(const AdjustedBlock& block, std::span<const StereoPair> pairs);

  const EngineRun& run_;
  const Aircraft& aircraft_;
  const PipelineOptions& options_;
  const ImageSource& images_;
  std::vector<StereoPair> pairs_;
  std::vector<size_t> snapshot_indices_;
  // Guards points_.
  std::mutex mutex_;
  // A pair's points depend on its two photographs alone: they are made once.
  std::map<std::pair<size_t, size_t>, Points> points_;
};

// Of a cell; `cell` lies on the map.
CellLayers LayersAt(const ElevationMap& map,
                    const HazardLayers& hazards,
                    const std::vector<CueLayer>& cues,
                    const cv::Mat1b& num_views,
                    const cv::Point& cell);

}  // namespace freelsd
