#include "tests/evaluation/fields/wind_plans.h"

#include <cstdio>
#include <stdexcept>

namespace freelsd {
namespace {

Candidate InWind(Candidate candidate, const std::optional<Eigen::Vector2d>& wind) {
  candidate.wind.reset();
  if (wind) candidate.wind = WindEstimate{.wind_in_world = *wind};
  return candidate;
}

}  // namespace

std::vector<NamedWind> SurveyWinds() {
  constexpr int kNumDirections = 8;
  std::vector<NamedWind> winds{{"calm", Eigen::Vector2d::Zero()}};
  for (const int speed_mps : {3, 6}) {
    for (int i = 0; i < kNumDirections; ++i) {
      const int from_deg = 360 * i / kNumDirections;
      char name[32];
      std::snprintf(name, sizeof(name), "%d m/s from %03d", speed_mps, from_deg);
      winds.push_back({name, -speed_mps * DirectionOf(RadFromDeg(from_deg))});
    }
  }
  return winds;
}

std::vector<Site> SitesInWind(const PlanBasis& basis, const std::optional<Eigen::Vector2d>& wind) {
  if (basis.map.grid.num_rows == 0) return {};
  const std::vector<HardObstacle> obstacles;
  const PlannableGround ground(
      basis.map, basis.hazards, obstacles, basis.aircraft, basis.options.hazard);
  const PlanOptions options{basis.options.approach, basis.options.backend.max_surroundings_m};
  const auto plan = [&](const Candidate& candidate) {
    Site site{.region = candidate.region, .wind = candidate.wind, .plan = {}};
    const PlanRequest request = RequestOf(candidate, basis.min_num_observations);
    site.plan = ground.PlanFor(request, basis.aircraft, options);
    return site;
  };
  std::vector<Site> sites;
  sites.reserve(basis.regions.size());
  for (const Candidate& region : basis.regions) sites.push_back(plan(InWind(region, wind)));
  return WithMapSites(std::move(sites),
                      {basis.map, basis.hazards, basis.num_views},
                      basis.aircraft,
                      basis.options,
                      [&](const std::vector<Region>& fields) {
                        std::vector<Site> planned;
                        planned.reserve(fields.size());
                        for (const Region& field : fields) {
                          planned.push_back(plan(InWind({field, std::nullopt}, wind)));
                        }
                        return planned;
                      });
}

void RequireSameSites(const std::vector<Site>& a, const std::vector<Site>& b) {
  bool is_same = a.size() == b.size();
  for (size_t i = 0; is_same && i < a.size(); ++i) {
    is_same = a[i].region.id == b[i].region.id && a[i].plan.verdict == b[i].plan.verdict &&
              a[i].plan.score == b[i].plan.score &&
              a[i].plan.touchdown_in_world == b[i].plan.touchdown_in_world;
  }
  if (!is_same) throw std::runtime_error("the sites planned again are not those of the engine");
}

std::vector<std::vector<Plan>> PlansInWinds(const PlanBasis& basis,
                                            const std::vector<NamedWind>& winds) {
  std::vector<std::vector<Plan>> plans(winds.size());
  if (basis.map.grid.num_rows == 0) return plans;
  for (const Candidate& region : basis.regions) {
    const ApproachPlanner planner(basis.map,
                                  basis.hazards,
                                  RequestOf(region, basis.min_num_observations),
                                  basis.aircraft,
                                  basis.options.approach);
    for (size_t i = 0; i < winds.size(); ++i) {
      plans[i].push_back(planner.PlanFor(winds[i].wind_in_world, Explanation::kNone));
    }
  }
  return plans;
}

std::vector<Candidate> GradedRegions(const Snapshot& snapshot) {
  std::vector<Candidate> graded;
  for (const Candidate& candidate : snapshot.regions) {
    if (candidate.region.grade > 0.0) graded.push_back(candidate);
  }
  return graded;
}

}  // namespace freelsd
