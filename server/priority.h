// Who waits for whom where processors are few: nothing may keep an emergency's answer waiting.
#pragma once

namespace freelsd {

// The calling thread, and those that it starts from then on, leave the processor to others that
// want it.
void GiveWay();

}  // namespace freelsd
