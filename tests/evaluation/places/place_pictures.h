// Pictures for a person who checks the answers.
#pragma once

#include <string>

#include "tests/evaluation/places/place_answers.h"

namespace freelsd {

// Writes FOLDER/PLACE__PHOTOGRAPH__VARIATION.png: the photograph, the borders of its regions in
// white, and the polygons. Their colour is the labelled class: green for grass, yellow for rough
// grass, red for the rest. The text is the first letters of the class, the id, the probability by
// regions and, after a slash, as one region. Throws std::runtime_error if the file cannot be
// written.
void DrawPlaceAnswers(const std::string& folder,
                      const PlacePhotograph& photograph,
                      const Segments& segments,
                      const PhotographAnswers& answers);

}  // namespace freelsd
