// The report on all answers: figures per place and pooled.
#pragma once

#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/places/place_answers.h"

namespace freelsd {

// Returns second_opinion, the rows pooled and other_scale (photographs taken from far lower or
// higher than ours), places (one row per place) and photographs (the answers themselves, sorted).
// Polygons on which two people disagree about grass or not grass count only in second_opinion.
nlohmann::json MakePlaceReport(std::vector<PhotographAnswers> answers);

// False if the answers order the pooled polygons worse than chance.
bool IsBetterThanChance(const nlohmann::json& report);

}  // namespace freelsd
