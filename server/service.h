// What the handlers share. Handlers touch storage only and never wait for the engine.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <semaphore>
#include <set>
#include <string>

#include "api/import/import.h"
#include "server/alternates.h"
#include "server/config.h"
#include "server/events.h"
#include "server/map_cache.h"
#include "server/metrics.h"
#include "server/page.h"
#include "server/tokens.h"
#include "storage/storage.h"

namespace freelsd {

inline constexpr int kMaxNumUploads = 8;
inline constexpr int kMaxNumStreams = 8;
inline constexpr int kMaxNumEventClients = 8;
// Of one wind rose: 0.2 ms each over an open field, 20 ms where most of it is obstructed.
inline constexpr size_t kMaxNumRoseWinds = 180;

struct Service {
  Service(const Config& settings, Storage& store) : config(settings), storage(store) {}

  const Config& config;
  Storage& storage;
  Page page;
  TokenList tokens;
  Metrics metrics;
  ImageLimits image_limits;
  // Of recall: its own, so that nothing else pushes maps out.
  mutable MapCache maps{size_t{192} << 20, size_t{64} << 20};
  EventLog events;
  Alternates alternates{*this};
  // Tells the worker that there is something new in storage.
  std::function<void()> wake_worker = [] {};

  // Held while ids are checked and rows inserted, so that both see the same.
  std::mutex intake_mutex;
  // Held while a flight is deleted, and while the worker stores a flight's sites.
  std::mutex sites_mutex;
  // Decoded images held at once by requests: 64 megapixels are 192 MiB each.
  std::counting_semaphore<2> decoders{2};
  // Wind roses planned at once, each for seconds where much is obstructed: others wait their turn.
  std::counting_semaphore<2> rose_planners{2};
  // Uploads read at once: each holds an encoded image in memory, and a thread.
  std::counting_semaphore<kMaxNumUploads> uploads{kMaxNumUploads};
  // Requests that last as long as a flight does: each holds a thread.
  std::counting_semaphore<kMaxNumStreams> streams{kMaxNumStreams};
  std::counting_semaphore<kMaxNumEventClients> event_clients{kMaxNumEventClients};
  bool IsReceiving(const std::string& flight_id) const;
  mutable std::mutex receiving_mutex;
  // Flights by id, once per upload that is being read.
  std::multiset<std::string> receiving;
  std::atomic<bool> is_stopping{false};
};

// An upload while it is read: marks its flight as receiving. Throws ApiError TooManyRequests when
// too many are read already, ShuttingDown when the server stops.
class Receiving {
 public:
  Receiving(Service& service, const std::string& flight_id);
  ~Receiving();
  Receiving(const Receiving&) = delete;
  Receiving& operator=(const Receiving&) = delete;

 private:
  Service& service_;
  std::string flight_id_;
};

// The same for requests that last as long as a flight does.
class Streaming {
 public:
  Streaming(Service& service, const std::string& flight_id);
  ~Streaming();
  Streaming(const Streaming&) = delete;
  Streaming& operator=(const Streaming&) = delete;

 private:
  Service& service_;
  std::string flight_id_;
};

}  // namespace freelsd
