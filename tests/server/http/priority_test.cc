// Which threads leave the processor to an emergency's answer, and which requests wait for a turn.
#include "server/http/priority.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <sys/resource.h>

namespace freelsd {
namespace {

int NicenessOfThisThread() { return getpriority(PRIO_PROCESS, 0); }

const StopIfUnwanted kWanted = [] {};

// Waits until it holds, or for half a minute.
void Await(const std::function<bool()>& holds) {
  for (int i = 0; i < 3000 && !holds(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  REQUIRE(holds());
}

bool IsRefused(LongQueue& queue) {
  try {
    const LongPlace place(queue, kWanted);
  } catch (const ApiError& error) {
    CHECK(error.code() == "TooManyRequests");
    CHECK(RetryAfterSeconds(error.code()));
    return true;
  }
  return false;
}

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

TEST_CASE("long computations: one computes, some wait in their order, the others are refused") {
  constexpr int kNumWaiting = 3;
  LongQueue queue({1, kNumWaiting});
  auto first = std::make_unique<LongPlace>(queue, kWanted);
  std::atomic<int> num_waiting{0}, num_done{0};
  std::vector<int> order;
  std::vector<std::thread> threads;
  for (int i = 0; i < kNumWaiting; ++i) {
    threads.emplace_back([&, i] {
      bool is_first_look = true;
      const LongPlace place(queue, [&] { num_waiting += std::exchange(is_first_look, false); });
      // One at a time.
      order.push_back(i);
      ++num_done;
    });
    Await([&] { return num_waiting == i + 1; });
  }
  CHECK(IsRefused(queue));
  CHECK(num_done == 0);
  first.reset();
  for (std::thread& thread : threads) thread.join();
  CHECK(order == std::vector{0, 1, 2});
  CHECK_FALSE(IsRefused(queue));
}

TEST_CASE("long computations: who leaves while waiting gives up the place") {
  LongQueue queue({1, 1});
  const LongPlace first(queue, kWanted);
  for (int i = 0; i < 3; ++i) {
    std::atomic<bool> is_waiting{false}, has_left{false}, is_dropped{false};
    std::thread waiting([&] {
      try {
        const LongPlace place(queue, [&] {
          is_waiting = true;
          if (has_left) throw ApiError("Unavailable", "the client has left");
        });
      } catch (const ApiError&) {
        is_dropped = true;
      }
    });
    Await([&] { return is_waiting.load(); });
    CHECK(IsRefused(queue));
    has_left = true;
    waiting.join();
    CHECK(is_dropped);
  }
}

}  // namespace freelsd
