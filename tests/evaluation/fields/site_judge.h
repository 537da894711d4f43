// Input: an accepted approach and what people see on the photographs. Output: whether it is safe.
//
// False safe: a cell of refused ground or of a thing lies under the touchdown disc or the ground
// roll, or a thing beside them reaches up to the final. Outlines get the benefit of the doubt: land
// is grown by LabelledGround::tolerance_m, and disc, roll and corridor are narrowed by it where
// they meet danger. Narrowing the path instead of the thing keeps walls, which are thinner than the
// tolerance. A thing is also moved outward along the final by it.
#pragma once

#include <string>

#include "engine/approach/approach.h"
#include "tests/evaluation/fields/labelled_ground.h"

namespace freelsd {

enum class Finding {
  kRight,      // 99 % of disc and roll are land, and nothing blocks the final
  kNotJudged,  // part of disc or roll is in doubt or has no outline
  kFalseSafe,
};
const char* NameOf(Finding finding);

struct SiteJudgement {
  Finding finding = Finding::kNotJudged;
  // "disc: refuse", "roll: tree", "final: wall"; empty if nothing is dangerous. The object's id.
  std::string cause;
  std::string object_id;
  // False safe, and it would not be without fences and poles.
  bool is_only_thin = false;
  // Kind of what reaches up to the circle; does not count.
  std::string circle;
  // Share of disc and roll on grown land, and in doubt.
  double land_ratio = 0.0;
  double doubt_ratio = 0.0;
};

SiteJudgement JudgeApproach(const LabelledGround& ground,
                            const Aircraft& aircraft,
                            const Approach& approach);

}  // namespace freelsd
