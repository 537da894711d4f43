// Detects wrong attitudes of frames, and estimates missing ones, from matches between frames.
#pragma once

#include <optional>
#include <vector>

#include "engine/tracks/attitude/planar_alignment.h"
#include "engine/tracks/frame_memory.h"

namespace freelsd {

// Rotation about the vertical (radians, counter-clockwise from above) that corrects a waiting
// frame's attitude. Nothing if the attitude agrees with the matches, or if the matches do not
// determine the rotation. An attitude that fits the directions of the frame's GPS baselines is
// kept, even if neighbours disagree.
std::optional<double> NeededTurn(const FrameMemory& memory, size_t frame);
// Rotates the camera about the vertical. If the rotation is near 180 deg, rotates by 180 deg about
// the optical axis instead, because photo viewers rotate photographs in this way.
void TurnFrame(FrameRecord& record, double turn);

// Groups (components) of waiting frames without attitude. The frames of a group are connected by
// matches, directly or through frames with a pose.
std::vector<std::vector<size_t>> WaitingComponents(const FrameMemory& memory);
// Whether a frame of the component is matched with a frame whose pose is known.
bool HasPosedNeighbour(const FrameMemory& memory, const std::vector<size_t>& component);
// Estimates the attitudes of the component's frames, in the same order. The poses of neighbours
// outside the component are held fixed.
std::vector<AlignmentFrame> SolveAttitudes(const FrameMemory& memory,
                                           const std::vector<size_t>& component);

}  // namespace freelsd
