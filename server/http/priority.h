// Lowers the priority of the engine's threads, so that they do not delay answers to emergencies.
#pragma once

namespace freelsd {

// Lowers the priority of the calling thread and of all threads that it starts later.
void GiveWay();

}  // namespace freelsd
