// Private to heights/. From measures to likelihoods.
#pragma once

#include "engine/heights/heights.h"

namespace freelsd {

// How a cell counts in the tables.
struct TableBin {
  int views = 0, contrast = 0, disagreement = 0, gain = 0;
};
constexpr int kNumViewBins = 4, kNumContrastBins = 3, kNumDisagreementBins = 8, kNumGainBins = 4;
constexpr int kNumTableBins = kNumViewBins * kNumContrastBins * kNumDisagreementBins * kNumGainBins;

// Nothing where the evidence is incomplete.
std::optional<TableBin> BinOf(const HeightEvidence& evidence, const cv::Point& cell);
// In the order of the table.
int IndexOf(const TableBin& bin);

// Logarithm of the ratio of two likelihoods of the evidence: something stands above the ground
// that the ground's height does not show, and nothing does.
double ThingLogRatio(const TableBin& bin);

// Standard deviation of a height whose peak has that width, metres.
double DeviationOf(double peak_width);

// Completes heights whose evidence is measured.
void Judge(const ElevationMap& proposal, const HeightsOptions& options, PhotographHeights& heights);

}  // namespace freelsd
