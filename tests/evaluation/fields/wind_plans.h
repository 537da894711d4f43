// Input: a finished map and regions. Output: the sites that the engine answers in many winds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline.h"

namespace freelsd {

struct NamedWind {
  // "calm", "3 m/s from 045".
  std::string name;
  // Where the air moves towards.
  Eigen::Vector2d wind_in_world = Eigen::Vector2d::Zero();
};

// Calm, then 3 m/s and 6 m/s from eight directions each.
std::vector<NamedWind> SurveyWinds();

// What all plans of a run share. All must outlive it.
struct PlanBasis {
  const ElevationMap& map;
  const HazardLayers& hazards;
  const cv::Mat1b& num_views;
  const std::vector<Candidate>& regions;
  int min_num_observations = 2;
  const Aircraft& aircraft;
  const PipelineOptions& options;
};

// The sites of EvaluateSites for this wind, measured without spread, or for an unknown wind. No
// other stage of it depends on the wind: this is its last stage, by the same functions, on the map
// that it made.
std::vector<Site> SitesInWind(const PlanBasis& basis, const std::optional<Eigen::Vector2d>& wind);

// Throws std::runtime_error unless the sites are the same: verdict, region, touchdown and score.
void RequireSameSites(const std::vector<Site>& a, const std::vector<Site>& b);

// One plan per region and wind, without further fields. Same order as the winds.
std::vector<std::vector<Plan>> PlansInWinds(const PlanBasis& basis,
                                            const std::vector<NamedWind>& winds);

// The regions with a grade, as the service evaluates them.
std::vector<Candidate> GradedRegions(const Snapshot& snapshot);

}  // namespace freelsd
