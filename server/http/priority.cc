#include "server/http/priority.h"

#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace freelsd {

void GiveWay() {
#if defined(__linux__)
  // About a tenth of the processor share of a normal thread. On Linux, 0 means the calling thread.
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNiceness);
#endif
}

}  // namespace freelsd
