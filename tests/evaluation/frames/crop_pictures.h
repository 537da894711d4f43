// Input: photographs and frames at one scale. Output: a picture per cover, with crops of each look
// in a row of its own.
#pragma once

#include <string>
#include <vector>

#include "tests/evaluation/frames/labelled_picture.h"

namespace freelsd {

// Writes FOLDER/crops_COVER.png: crops of 40 m x 40 m that show the cover most, and
// FOLDER/NAME.png, every rendered frame as it is. `looks`: from top to bottom.
void DrawCrops(const std::string& folder,
               const std::vector<LabelledPicture>& pictures,
               const std::vector<std::string>& looks);

}  // namespace freelsd
