#include "server/descriptors.h"

#include <sys/resource.h>

namespace freelsd {

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  // If it fails, connections are closed earlier to make room for others.
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace freelsd
