// Input: what worlds say of their heights. Output: figures of one world, and of all.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "tests/evaluation/heights/height_scores.h"

namespace freelsd {

// {num_cells, median_m, p95_m, ..., by_place, by_told_deviation}, of one world or of several that
// are added up. The plain figures are those of all places, without the plane.
nlohmann::json HeightFigures(const HeightScores& scores);

// For a world's record: {figures, counts}.
nlohmann::json HeightRecord(const HeightScores& scores);

// A row of a table, in the order of the spacings: "  6 m apart".
std::string NameOfSpacing(double spacing_m);

// Pooled figures of all records, by_spacing, and of the main figures the median and the largest of
// the worlds. Empty if no record has heights.
nlohmann::json HeightTotals(const nlohmann::json& records);

}  // namespace freelsd
