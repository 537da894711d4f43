// Private to heights/. Made by freelsd-heights --table --frames 24 on worlds of the tuning pool:
// the counts of --seed 1000 --worlds 2, and of --seed 1002 --worlds 2 --texture recorded
// --conditions recorded --cell 0.1, added.
#pragma once

#include <array>

#include "engine/heights/likelihood.h"

namespace freelsd {

// Logarithm of the share of a bin among cells with a hidden thing over its share among open ground,
// times 10. By views, contrast, disagreement, gain.
// 12551 cells with a hidden thing, 146240 of open ground.
// clang-format off
constexpr std::array<int, kNumTableBins> kThingLogRatio10{
    -52, -54, -46, -17, -21, -22, 10, 13, 0, 12, 20, 13, 20, 24, 17, 20, 24, 24, 24, 24, 24, 24, 24, 24,
    -62, -39, -28, -30, -36, -21, -10, -14, -10, -1, -5, 6, 16, 19, 13, 24, 22, 18, 35, 31, 27, 24, 28, 31,
    -28, -22, -13, -21, -19, -3, 4, -1, 6, 12, 10, 13, 21, 22, 25, 31, 32, 33, 35, 40, 36, 47, 47, 43,
    -57, -46, -25, -20, -11, -12, 3, 10, 2, 20, 17, 15, 24, 24, 20, 24, 24, 24, 24, 24, 24, 24, 24, 24,
    -58, -35, -11, -46, -19, -17, -27, -18, -11, -8, -11, -15, 8, 8, -5, 25, 29, 11, 40, 26, 19, 20, 24, 24,
    -29, -22, -6, -27, -10, -16, -19, -11, 5, 1, 9, 13, 10, 16, 15, 26, 31, 31, 42, 41, 37, 53, 53, 42,
    -60, -37, -6, -30, -13, -5, 3, 5, 4, 24, 20, 10, 24, 24, 20, 24, 24, 24, 24, 24, 24, 24, 24, 24,
    -49, -27, -4, -54, -22, -1, -30, -13, -5, -5, -3, -9, 4, 6, 0, 18, 17, 3, 37, 24, 22, 28, 28, 22,
    -20, -8, 9, -30, -16, -4, -25, -11, 4, -19, -3, 1, 3, 6, 6, 23, 26, 21, 39, 39, 30, 52, 48, 35,
    -65, -25, -5, -37, -11, -1, -1, -1, 7, 17, 20, 17, 20, 24, 20, 24, 24, 24, 24, 24, 24, 24, 24, 24,
    -61, -21, 4, -51, -22, -4, -45, -19, -6, -22, -18, -9, -8, -4, -8, 21, 9, -8, 21, 19, -4, 24, 24, 15,
    -30, -4, 24, -24, -14, 1, -25, -12, -1, -14, -5, 2, 1, 15, 17, 28, 28, 18, 50, 42, 26, 57, 47, 31,
};
// clang-format on

}  // namespace freelsd
