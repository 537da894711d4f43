// State common to all endpoints that receive data: settings, storage, events, limits of
// concurrency.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <semaphore>
#include <set>
#include <string>

#include "api/api.h"
#include "server/config.h"
#include "server/http/http.h"
#include "storage/storage.h"

namespace freelsd {

// Thread-safe, except that both callbacks must be set before the first request.
struct Intake {
  Intake(const Config& settings, Storage& store, EventLog& log)
      : config(settings), storage(store), events(log) {}
  // True while the server reads an upload or a stream for the flight.
  bool IsReceiving(const std::string& flight_id) const;

  const Config& config;
  Storage& storage;
  EventLog& events;
  ImageLimits image_limits = kLimits.image;
  // Called after new input for the engine was stored.
  std::function<void()> wake_worker = [] {};
  // Called after a flight's pose or wind changed.
  std::function<void(const std::string& flight_id)> on_new_pose = [](const std::string&) {};

  // Guards the ids of new frames, from their check until their rows are inserted.
  std::mutex intake_mutex;
  // Limits the number of images decoded at the same time: 64 megapixels take 192 MiB.
  std::counting_semaphore<> decoders{kLimits.concurrency.max_num_decoders};
  // Limits the number of uploads at the same time. Each upload holds a thread, and an encoded image
  // in memory.
  std::counting_semaphore<> uploads{kLimits.concurrency.max_num_uploads};
  // Limits the number of requests that last as long as a flight. Each of them holds a thread.
  std::counting_semaphore<> streams{kLimits.concurrency.max_num_streams};
  // Guards `receiving`.
  mutable std::mutex receiving_mutex;
  // Ids of flights: one entry for each upload or stream that is being read.
  std::multiset<std::string> receiving;
  std::atomic<bool> is_stopping{false};
};

// Marks a flight as receiving while an upload is read. The constructor throws ApiError
// TooManyRequests if there are too many uploads, or ShuttingDown if the server is stopping.
class Receiving {
 public:
  Receiving(Intake& intake, const std::string& flight_id);
  ~Receiving();
  Receiving(const Receiving&) = delete;
  Receiving& operator=(const Receiving&) = delete;

 private:
  Intake& intake_;
  std::string flight_id_;
};

// The same as Receiving, for a request that lasts as long as a flight.
class Streaming {
 public:
  Streaming(Intake& intake, const std::string& flight_id);
  ~Streaming();
  Streaming(const Streaming&) = delete;
  Streaming& operator=(const Streaming&) = delete;

 private:
  Intake& intake_;
  std::string flight_id_;
};

}  // namespace freelsd
