// freelsd-server: the HTTP service; api/openapi.yaml describes its interface.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <future>

#include <pthread.h>
#include <spdlog/spdlog.h>

#include "server/app.h"
#include "server/descriptors.h"
#include "server/jobs/jobs.h"
#include "server/supervisor.h"

namespace freelsd {
namespace {

// Exit codes of sysexits.h. kExitConfig: invalid settings, or data of another version.
// kExitTemporary: port or folder in use, so a later start may work.
constexpr int kExitConfig = 78;
constexpr int kExitTemporary = 75;
// Together less than 10 s, the time that container engines wait before they kill.
constexpr std::chrono::milliseconds kEnginePatience{6000};
constexpr std::chrono::milliseconds kRequestPatience{2000};

sigset_t BlockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

int Run(int argc, char** argv) {
  const std::optional<Config> config = ReadConfig(argc, argv);
  if (!config) return EXIT_SUCCESS;
  const sigset_t signals = BlockStopSignals();
  App app(*config);
  std::printf("freelsd-server listens on http://%s:%d/\n", config->host.c_str(), app.port());
  if (const auto port = app.emergency_port()) {
    std::printf("emergency recall on http://%s:%d/\n", config->emergency->host.c_str(), *port);
  }
  std::fflush(stdout);
  std::future<void> http = std::async(std::launch::async, [&app] { app.Run(); });
  NotifySupervisor("READY=1");
  int signal = 0;
  {
    const Heartbeat heartbeat([&app] { return app.CanRecall(); });
    sigwait(&signals, &signal);
  }
  NotifySupervisor("STOPPING=1");
  spdlog::info("stopping");
  const bool has_stopped =
      app.Stop(kEnginePatience) && http.wait_for(kRequestPatience) == std::future_status::ready;
  // Neither a stage of the engine nor a slow upload can be interrupted. Ending here is safe: all
  // acknowledged data is on disk, and the next start continues the job.
  if (!has_stopped) std::_Exit(EXIT_SUCCESS);
  return EXIT_SUCCESS;
}

int Fail(const std::exception& error, int exit_code) {
  std::fprintf(stderr, "freelsd-server: %s\n", error.what());
  return exit_code;
}

}  // namespace
}  // namespace freelsd

int main(int argc, char** argv) {
  freelsd::LimitHeapPools();
  freelsd::RaiseDescriptorLimit();
  try {
    return freelsd::Run(argc, argv);
  } catch (const freelsd::ConfigError& error) {
    return freelsd::Fail(error, freelsd::kExitConfig);
  } catch (const freelsd::StorageError& error) {
    const bool is_other = error.fault == freelsd::StorageFault::kOtherSchema;
    return freelsd::Fail(error, is_other ? freelsd::kExitConfig : freelsd::kExitTemporary);
  } catch (const std::exception& error) {
    return freelsd::Fail(error, freelsd::kExitTemporary);
  }
}
