// Input: judged plans of one flight and aircraft in many winds. Output: the places they are about.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/approach/approach.h"
#include "tests/evaluation/fields/site_judge.h"

namespace freelsd {

// An accepted plan.
struct JudgedPlan {
  std::string wind;
  int region_id = 0;
  Verdict verdict = Verdict::kUnverified;
  Approach approach;
  SiteJudgement judgement;
};

// Touchdowns within one touchdown disc of its first one, in whatever wind.
struct DistinctSite {
  // The first plan, or the first false safe one.
  JudgedPlan shown;
  int num_plans = 0;
  // False safe if any plan is, else not judged if any plan is not.
  Finding finding = Finding::kRight;
  // False safe, and all its false safe plans would not be without fences and poles.
  bool is_only_thin = false;
  // Number of false safe plans by cause.
  std::map<std::string, int> causes;
};

// In the order of the plans. `diameter`: of the touchdown disc.
std::vector<DistinctSite> DistinctSites(const std::vector<JudgedPlan>& plans, double diameter);

}  // namespace freelsd
