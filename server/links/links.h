// Links to autopilots, in memory: what each one reported last, and the commands for it. After a
// restart of the server, the next report of a link makes it whole again.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/import/links/links.h"

namespace freelsd {

using LinkTime = std::chrono::steady_clock::time_point;

// Thread-safe. The caller passes the time, so that ages can be tested.
class LinkBoard {
 public:
  // A link counts as silent if it has reported nothing for this time.
  static constexpr std::chrono::seconds kSilentAfter{5};
  // A command is not handed over later than this: the aircraft is elsewhere by then.
  static constexpr std::chrono::seconds kCommandHoldsFor{10};
  // The outcome of a command is remembered for this time.
  static constexpr std::chrono::minutes kCommandKeptFor{10};

  // NOLINTNEXTLINE(bugprone-exception-escape): an empty json throws nothing.
  struct Taken {
    // The commands that the link has not reported on yet, as a JSON array.
    nlohmann::json commands;
    // The decisions that were not reported before.
    std::vector<LinkDecision> new_decisions;
  };
  // Throws ApiError LinkInUse if another run of a program reports as this link: a command would go
  // to either of two aircraft. TooManyLinks if the board is full of links that are heard.
  Taken Put(const std::string& id, LinkReport report, LinkTime now);

  // Throws ApiError NoSuchLink.
  nlohmann::json Find(const std::string& id, LinkTime now);
  // All links, ordered by id, as a JSON array.
  nlohmann::json List(LinkTime now);

  // Queues a command for the run of the link that is heard now, and returns the command. Throws
  // ApiError NoSuchLink, LinkSilent, or TooManyRequests.
  nlohmann::json Queue(const std::string& id, const CommandRequest& request, LinkTime now);

 private:
  struct Command {
    std::string id;
    CommandRequest request;
    // The run of the link's program that it is for.
    std::string run;
    LinkTime issued_at;
    std::string issued_at_text;
    CommandState state = CommandState::kQueued;
    std::string detail;
  };
  struct Link {
    LinkReport report;
    LinkTime heard_at;
    int64_t last_decision = 0;
    std::deque<Command> commands;
  };

  // The caller holds mutex_, also for the next two.
  Link& Existing(const std::string& id);
  void MakeRoom(LinkTime now);
  static void Expire(Link& link, LinkTime now);
  static void TakeOutcomes(Link& link);
  static nlohmann::json JsonOf(const Command& command);
  static nlohmann::json JsonOf(const std::string& id, const Link& link, LinkTime now);

  // Guards links_.
  std::mutex mutex_;
  std::map<std::string, Link> links_;
};

}  // namespace freelsd
