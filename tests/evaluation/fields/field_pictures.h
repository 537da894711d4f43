// The photographs of a survey with the outlines and what the engine accepted, to be looked
// at.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/fields/field_survey.h"

namespace freelsd {

// Writes into the folder:
// - PHOTOGRAPH.png for each photograph with outlines: all outlines and all accepted sites;
// - PHOTOGRAPH-map.png: the same over the engine's hazard classes;
// - site-NN.png for each accepted site, on the photograph that shows most of it;
// - blind-NAME-site-NN.png for the first false safe sites of each blinding.
// Outlines: land green, refused red, doubt grey, things orange; thick as drawn on this photograph,
// thin as projected from all. Sites: right white, not judged yellow, false safe magenta.
void DrawSurvey(const std::string& folder,
                const FieldSurvey& survey,
                const std::vector<Frame>& frames);

}  // namespace freelsd
