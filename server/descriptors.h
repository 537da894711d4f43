// Limit of the number of files and connections that this process may have open.
#pragma once

namespace freelsd {

// Raises the limit as far as the system allows. The usual default of 1024 is too small for the
// connections of two listeners.
void RaiseDescriptorLimit();

}  // namespace freelsd
