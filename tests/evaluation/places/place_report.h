// The report on all answers: figures per variation of the photographs, per place and pooled, in
// JSON and as Markdown.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/evaluation/places/place_answers.h"

namespace freelsd {

// Returns settings, second_opinion, variations and photographs (the answers themselves, sorted).
// variations holds, for each variation, the rows pooled, other_scale (photographs taken from far
// lower or higher than ours) and one row per place. A row has by_regions (the polygon's regions as
// the engine segments them) and as_one_region (the polygon itself, which judges the classifier
// without the segmentation). Polygons on which two people disagree about grass or not grass count
// only in second_opinion.
nlohmann::json MakePlaceReport(const nlohmann::json& settings,
                               std::vector<PhotographAnswers> answers);

// Tables for a person.
std::string PlaceReportAsMarkdown(const nlohmann::json& report);

// False if the answers of any variation order the pooled polygons worse than chance.
bool IsBetterThanChance(const nlohmann::json& report);

}  // namespace freelsd
