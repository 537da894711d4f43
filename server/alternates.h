// The standing list: for each flight that streams in, the best sites in reach from its latest pose,
// ready before anyone asks.
#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

namespace freelsd {

struct Service;

class Alternates {
 public:
  // `service` is used until Stop.
  explicit Alternates(Service& service) : service_(service) {}
  ~Alternates();
  Alternates(const Alternates&) = delete;
  Alternates& operator=(const Alternates&) = delete;

  void Start();
  void Stop();
  // The flight's pose or wind has changed. Never waits.
  void Wake(const std::string& flight_id);
  // The kept answer, as JSON text; nothing where there is none yet.
  std::optional<std::string> Find(const std::string& flight_id) const;
  void Forget(const std::string& flight_id);

  // Makes the answer now, keeps it and tells of it; empty where there is no such flight.
  std::string Update(const std::string& flight_id);

 private:
  void Run();

  Service& service_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::string> due_;
  std::map<std::string, std::string> answers_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace freelsd
