// The state that handlers and worker share. A handler uses storage only; it never waits for the
// engine.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <semaphore>

#include "server/base_map/base_map.h"
#include "server/following/following.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/jobs/progress_board.h"
#include "server/links/links.h"
#include "server/maps/maps.h"
#include "server/recall/recall.h"

namespace freelsd {

// Memory of reach's cache: 5 bytes for each 4 square metres of stored maps.
constexpr size_t kMaxBytesOfGroundPatches = size_t{64} << 20;

// Of at least 32 HTTP threads.
constexpr int kMaxNumChangeWaiters = 8;

// Memory of finished pictures of flights' maps.
constexpr size_t kMaxBytesOfPictures = size_t{32} << 20;

// Refers to objects that the App owns. Thread-safe, because of the mutex and the semaphores.
struct Service {
  Service(Intake& in, MapCache& cache, Alternates& standing, const BaseMap& base)
      : config(in.config),
        storage(in.storage),
        events(in.events),
        intake(in),
        maps(cache),
        alternates(standing),
        base_map(base) {}

  const Config& config;
  Storage& storage;
  EventLog& events;
  Intake& intake;
  MapCache& maps;
  Alternates& alternates;
  const BaseMap& base_map;
  LongQueues long_queues;
  GroundPatches ground_patches{kMaxBytesOfGroundPatches};
  // Pictures of flights' maps.
  MapPictures pictures{kMaxBytesOfPictures};
  Page page;
  TokenList tokens;
  Metrics metrics;
  ProgressBoard progress;
  LinkBoard links;
  // Of the server that this one follows.
  Copy copy;
  // Limits clients that wait for changes in a thread.
  std::counting_semaphore<> change_waiters{kMaxNumChangeWaiters};
  std::atomic<int64_t> removals_forgotten_at_us{0};

  // Guards the number of stored obstacles, from its check until they are stored.
  std::mutex obstacles_mutex;
  // Limits clients that listen to events.
  std::counting_semaphore<> event_clients{kLimits.events.max_num_clients};
};

}  // namespace freelsd
