// Which threads leave the processor to an emergency's answer.
#include "server/http/priority.h"

#include <thread>

#include <doctest/doctest.h>
#include <sys/resource.h>

namespace freelsd {
namespace {

int NicenessOfThisThread() { return getpriority(PRIO_PROCESS, 0); }

}  // namespace

TEST_CASE("priority: a thread that gives way does so with those it starts, and with no other") {
  const int before = NicenessOfThisThread();
  int own = before, started = before;
  std::thread giving([&] {
    GiveWay();
    own = NicenessOfThisThread();
    std::thread([&] { started = NicenessOfThisThread(); }).join();
  });
  giving.join();
  // 19 is the most there is.
  CHECK((own > before || before == 19));
  CHECK(started == own);
  CHECK(NicenessOfThisThread() == before);
}

}  // namespace freelsd
