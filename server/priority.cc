#include "server/priority.h"

#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace freelsd {

void GiveWay() {
#if defined(__linux__)
  // A tenth of the share of a thread that does not. Of the calling thread, as Linux understands 0.
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNiceness);
#endif
}

}  // namespace freelsd
