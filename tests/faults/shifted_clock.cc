// Preloaded into a server under test: a wall clock that somebody sets. The file named by
// FREELSD_CLOCK_FILE is read at every look, so that it can change while the server runs: "SECONDS"
// that the clock is off, or "at SECONDS" since 1970, where it stands still and the time since the
// start of the machine with it. Other clocks stay true.
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <dlfcn.h>
#include <sys/time.h>

namespace {

struct Setting {
  bool stands = false;
  long seconds = 0;
};

Setting ReadSetting() {
  Setting setting;
  const char* const path = std::getenv("FREELSD_CLOCK_FILE");
  FILE* const file = path == nullptr ? nullptr : std::fopen(path, "r");
  if (file == nullptr) return setting;
  char text[64] = {};
  if (std::fgets(text, sizeof(text), file) != nullptr) {
    setting.stands = std::sscanf(text, "at %ld", &setting.seconds) == 1;
    if (!setting.stands && std::sscanf(text, "%ld", &setting.seconds) != 1) setting = {};
  }
  std::fclose(file);
  return setting;
}

void Set(clockid_t clock, timespec& now) {
  const Setting setting = ReadSetting();
  if (setting.stands) {
    now = {setting.seconds, 0};
  } else if (clock == CLOCK_REALTIME) {
    now.tv_sec += setting.seconds;
  }
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  using Function = int (*)(clockid_t, timespec*);
  static const auto kReal = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int result = kReal(clock, now);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_BOOTTIME)) Set(clock, *now);
  return result;
}

extern "C" int gettimeofday(timeval* now, void*) noexcept {
  timespec exact{};
  const int result = clock_gettime(CLOCK_REALTIME, &exact);
  now->tv_sec = exact.tv_sec;
  now->tv_usec = exact.tv_nsec / 1000;
  return result;
}

extern "C" time_t time(time_t* result) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (result != nullptr) *result = now.tv_sec;
  return now.tv_sec;
}
