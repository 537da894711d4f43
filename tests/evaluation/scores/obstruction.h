// Input: a world and its truth map. Output: what stands at a place, what is wrong with a cell of
// ground, and whether it is too thin to be seen from the air.
#pragma once

#include <string>

#include "tests/evaluation/truth_map.h"

namespace freelsd {

// Fences, poles and wires are too thin for 0.2 m of ground sampling.
enum class ThinThings { kCount, kIgnore };

// "fence", "pole" or "wire".
bool IsThinName(const std::string& name);

// Distance between samples that steps over no cell of the world.
double StepOf(const World& world);

// World z of the highest thing in the world's cell at a place.
double TopOf(const World& world, const Eigen::Vector2d& place, ThinThings thin);

// Name of the thing at a place that an aircraft hits: a cover, "wire" or "ground".
std::string NameOfThing(const World& world, const Eigen::Vector2d& place, ThinThings thin);

// What is wrong with a cell of the truth map: "" or a cover, "steep", "rough", "outside".
std::string NameOfFault(const TruthMap& truth, const cv::Point& cell);

// Whether a fence, a pole or a wire causes the fault of the cell. A post makes the cells around it
// rough: they count as the post's.
bool IsThinFault(const TruthMap& truth, const cv::Point& cell);

}  // namespace freelsd
