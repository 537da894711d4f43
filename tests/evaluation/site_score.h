// Input: a plan of the engine and the world it is about. Output: whether it was safe, in truth.
//
// False safe, of a site that is `landable` or `unverified`: a truth cell within the touchdown
// uncertainty or on the ground-roll strip is not landable, or the final runs into something; of a
// `landable` one also: the loiter circle does.
//
// Where a site is: exactly where its world coordinates say, horizontally. The aircraft will find it
// by the same kind of navigation that placed it, but not with the same error on another day, so an
// error of the whole block is the site's own error. It is reported beside the verdict, and every
// site is scored a second time with the block moved back, which tells navigation from mapping.
// Heights count from the true ground at the touchdown: nobody flies the last metres by absolute
// altitude, and a bias of the altimeter is in map and aircraft alike.
#pragma once

#include <optional>
#include <string>

#include "engine/approach/approach.h"
#include "tests/evaluation/truth_map.h"

namespace freelsd {

struct SafetyScore {
  // What is wrong at the touchdown disc or on the strip: "" or a cover, "steep", "rough",
  // "outside". What is too thin to be seen is named only where nothing else is wrong, "doubt" only
  // where not even that is.
  std::string ground_fault;
  // What the final, or the loiter, hits: "" or a cover or "ground"; the same holds.
  std::string final_fault;
  std::string loiter_fault;
  // Metres from the touchdown to the nearest ground that is not landable.
  double free_distance = 0.0;
  // Least height of final and loiter over what stands in their corridor; negative is a collision.
  double final_clearance = 0.0;
  double loiter_clearance = 0.0;
  // Where the final hits what `final_fault` names, or where it is lowest.
  Eigen::Vector2d final_worst_place = Eigen::Vector2d::Zero();

  // Of an answer with that verdict; the loiter counts for kLandable only.
  bool IsFalseSafe(Verdict verdict) const;
  // Accepted on ground of which nobody can tell what it is, and nothing else is wrong: such a site
  // counts for nothing.
  bool IsInDoubt(Verdict verdict) const;
  // It is, and would not be without fences, poles and wires.
  bool IsOnlyThin(Verdict verdict) const;
};

// `shift`: horizontal error of the block that is taken off first (estimate less truth); zero for
// the strict score. Nothing for a refused plan without an approach; throws std::invalid_argument
// for an accepted one: it could not be judged.
std::optional<SafetyScore> ScorePlan(const World& world,
                                     const TruthMap& truth,
                                     const Aircraft& aircraft,
                                     const Plan& plan,
                                     const Eigen::Vector2d& shift);

}  // namespace freelsd
