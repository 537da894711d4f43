#include "tests/evaluation/fields/distinct_sites.h"

#include <algorithm>

namespace freelsd {
namespace {

struct Group {
  Eigen::Vector2d touchdown = Eigen::Vector2d::Zero();
  std::vector<const JudgedPlan*> plans;
};

std::vector<Group> GroupsOf(const std::vector<JudgedPlan>& plans, double diameter) {
  std::vector<Group> groups;
  for (const JudgedPlan& plan : plans) {
    const Eigen::Vector2d touchdown = plan.approach.touchdown_in_world.head<2>();
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      return (group.touchdown - touchdown).norm() <= diameter;
    });
    if (same != groups.end()) {
      same->plans.push_back(&plan);
    } else {
      groups.push_back({touchdown, {&plan}});
    }
  }
  return groups;
}

DistinctSite SiteOf(const Group& group) {
  DistinctSite site;
  site.shown = *group.plans.front();
  site.num_plans = static_cast<int>(group.plans.size());
  bool is_any_solid = false;
  for (const JudgedPlan* plan : group.plans) {
    const SiteJudgement& judgement = plan->judgement;
    if (judgement.finding == Finding::kFalseSafe) {
      if (site.finding != Finding::kFalseSafe) site.shown = *plan;
      is_any_solid = is_any_solid || !judgement.is_only_thin;
      ++site.causes[judgement.cause];
    }
    site.finding = std::max(site.finding, judgement.finding);
  }
  site.is_only_thin = site.finding == Finding::kFalseSafe && !is_any_solid;
  return site;
}

}  // namespace

std::vector<DistinctSite> DistinctSites(const std::vector<JudgedPlan>& plans, double diameter) {
  std::vector<DistinctSite> sites;
  const std::vector<Group> groups = GroupsOf(plans, diameter);
  sites.reserve(groups.size());
  for (const Group& group : groups) sites.push_back(SiteOf(group));
  return sites;
}

}  // namespace freelsd
