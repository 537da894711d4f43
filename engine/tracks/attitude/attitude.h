// Attitudes of frames from their matches: finds wrong ones and solves missing ones.
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/attitude/planar_alignment.h"
#include "engine/tracks/frame_memory.h"

namespace freelsd {

// Turn about the vertical (counter-clockwise from above) that corrects a waiting frame's attitude;
// nothing if it agrees with the matches or is undetermined. If the attitude fits the direction of
// the frame's GPS baselines, it is trusted over the neighbours.
std::optional<double> NeededTurn(const FrameMemory& memory, size_t frame);
// Turns the camera. Prefers a multiple of 90 deg about its axis, as photo viewers apply, if that
// fits.
void TurnFrame(FrameRecord& record, double turn);

// Waiting frames without attitude, connected by matches or by a frame with pose.
std::vector<std::vector<size_t>> WaitingComponents(const FrameMemory& memory);
// Whether a frame of the component is matched with a frame whose pose is known.
bool HasPosedNeighbour(const FrameMemory& memory, const std::vector<size_t>& component);
// Attitudes of the component's frames, same order, relative to their posed neighbours.
std::vector<AlignmentFrame> SolveAttitudes(const FrameMemory& memory,
                                           const std::vector<size_t>& component);

}  // namespace freelsd
