// The number of files and connections that this process may have open.
#pragma once

namespace freelsd {

// Raises the limit as far as the system lets it. The usual default, 1024, is less than the
// connections of two listeners.
void RaiseDescriptorLimit();

}  // namespace freelsd
