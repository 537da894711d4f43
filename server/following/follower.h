// Keeps this server's copy of another one's sites, maps and obstacles in step, and sends back what
// was made here, in a thread of its own.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "server/following/copy.h"
#include "server/following/merging.h"
#include "server/http/http.h"

namespace freelsd {

struct FollowOptions {
  // "https://host[:port][/prefix]".
  std::string url;
  BoundingBox area{};
  // As in the query: "west,south,east,north".
  std::string area_text;
  // Empty: none is sent.
  std::string token;
};

// "west,south,east,north" in degrees; west > east crosses the antimeridian. Throws ApiError
// InvalidQuery.
BoundingBox ParseArea(const std::string& text);
// The first line. Throws ConfigError if the file cannot be read, or anyone but its owner can.
std::string ReadFollowToken(const std::filesystem::path& file);

// It takes turns: all pages that there are, then what was made here, then it waits for news. So
// nothing that is told is older than what was sent before.
class Follower {
 public:
  // `on_merged` is called with what was taken, by the thread.
  Follower(Storage& storage,
           MapCache& maps,
           Copy& copy,
           FollowOptions options,
           std::function<void(const MergeResult&)> on_merged);
  ~Follower();
  Follower(const Follower&) = delete;
  Follower& operator=(const Follower&) = delete;

  void Start();
  void Stop();

 private:
  void Run();
  // Until nothing is left on both sides; then it waits for news.
  void KeepInStep();
  // One page; false if it was the last.
  bool Pull(int wait_s);
  nlohmann::json AskForPage(const std::string& since, const std::string& subjects, int wait_s);
  // All maps and obstacles from there on: no site may be known without them, also if the link is
  // cut before the last page.
  void PullGround(std::string since);
  void EndPass();
  void BeginAnew(const std::string& why);
  void TakePage(const nlohmann::json& page);
  void FetchMaps(const std::vector<ToldChange>& changes);
  // Some of what the followed server does not know; false if it knows everything.
  bool Push();
  void Send(const std::vector<ChangeRow>& changes);
  // Not sent again for a while.
  void Refuse(const std::vector<ChangeRow>& changes);
  // Throws LinkFailure at a 409 that is not for a missing map.
  httplib::Result Post(const nlohmann::json& body);
  void SendMaps(const nlohmann::json& problem);
  void Remember(bool is_in_step, int64_t asked_at_us);
  // False if it is stopping.
  bool Pause(double seconds);

  Storage& storage_;
  MapCache& maps_;
  Copy& copy_;
  const FollowOptions options_;
  const std::function<void(const MergeResult&)> on_merged_;
  std::string path_prefix_;
  httplib::Client client_;

  // They belong to the thread.
  FollowState state_;
  // In a pass from the beginning: what was told so far.
  bool is_anew_ = false;
  std::vector<ChangeKey> told_;
  int64_t remembered_at_us_ = 0;
  // Maps and obstacles up to the last page are known.
  bool has_ground_ = false;
  // Numbers of changes that the followed server refused, and when.
  std::map<int64_t, std::chrono::steady_clock::time_point> refused_;

  // Guards is_stopping_.
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace freelsd
