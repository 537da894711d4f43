// Attitudes of remembered frames from their matches: wrong ones are found, missing ones solved.
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/frame_memory.h"
#include "engine/tracks/planar_alignment.h"

namespace freelsd {

// Turn about the vertical (counter-clockwise from above) by which the given attitude of a waiting
// frame disagrees with its matches; nothing where it agrees or nobody can tell. A frame whose
// attitude fits the direction of its GPS baselines is believed against its neighbours.
std::optional<double> NeededTurn(const FrameMemory& memory, size_t frame);
// Turns the camera; by a multiple of 90 deg about its axis, as a photo viewer does, where that
// fits.
void TurnFrame(FrameRecord& record, double turn);

// Waiting frames without attitude that hang together by matches, or by a frame with pose.
std::vector<std::vector<size_t>> WaitingComponents(const FrameMemory& memory);
// Whether one of them is matched with a frame whose pose is known.
bool HasPosedNeighbour(const FrameMemory& memory, const std::vector<size_t>& component);
// Attitudes of the component's frames, same order, against their posed neighbours.
std::vector<AlignmentFrame> SolveAttitudes(const FrameMemory& memory,
                                           const std::vector<size_t>& component);

}  // namespace freelsd
