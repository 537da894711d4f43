#include "server/links/links.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/http/http.h"

namespace freelsd {
namespace {

double SecondsBetween(LinkTime from, LinkTime to) {
  return std::max(0.0, std::chrono::duration<double>(to - from).count());
}

bool IsHeard(LinkTime heard_at, LinkTime now) { return now - heard_at < LinkBoard::kSilentAfter; }

// Ages were true when the link reported them.
void AddAge(double seconds, nlohmann::json& object) {
  const auto age = object.find("age_s");
  if (age != object.end() && age->is_number()) *age = age->get<double>() + seconds;
}

}  // namespace

LinkBoard::Taken LinkBoard::Put(const std::string& id, LinkReport report, LinkTime now) {
  const std::lock_guard lock(mutex_);
  auto found = links_.find(id);
  if (found == links_.end()) {
    MakeRoom(now);
    found = links_.emplace(id, Link{}).first;
  } else if (found->second.report.run != report.run && IsHeard(found->second.heard_at, now)) {
    throw ApiError("LinkInUse",
                   "another program reports as link " + id + "; each needs a name of its own");
  }
  Link& link = found->second;
  Taken taken{nlohmann::json::array(), {}};
  if (link.report.run != report.run) link.last_decision = 0;
  std::copy_if(report.decisions.begin(),
               report.decisions.end(),
               std::back_inserter(taken.new_decisions),
               [&link](const LinkDecision& each) { return each.number > link.last_decision; });
  if (!report.decisions.empty()) {
    link.last_decision = std::max(link.last_decision, report.decisions.back().number);
  }
  link.report = std::move(report);
  link.heard_at = now;
  TakeOutcomes(link);
  Expire(link, now);
  for (const Command& command : link.commands) {
    const bool is_waiting =
        command.state == CommandState::kQueued && command.run == link.report.run;
    if (is_waiting) taken.commands.push_back(JsonOf(command));
  }
  return taken;
}

nlohmann::json LinkBoard::Find(const std::string& id, LinkTime now) {
  const std::lock_guard lock(mutex_);
  Link& link = Existing(id);
  Expire(link, now);
  return JsonOf(id, link, now);
}

nlohmann::json LinkBoard::List(LinkTime now) {
  const std::lock_guard lock(mutex_);
  nlohmann::json list = nlohmann::json::array();
  for (auto& [id, link] : links_) {
    Expire(link, now);
    list.push_back(JsonOf(id, link, now));
  }
  return list;
}

nlohmann::json LinkBoard::Queue(const std::string& id,
                                const CommandRequest& request,
                                LinkTime now) {
  const std::lock_guard lock(mutex_);
  Link& link = Existing(id);
  Expire(link, now);
  if (!IsHeard(link.heard_at, now) || !link.report.is_connected) {
    throw ApiError("LinkSilent",
                   IsHeard(link.heard_at, now) ? "link " + id + " does not hear its autopilot"
                                               : "link " + id + " has reported nothing for 5 s");
  }
  const auto num_queued =
      std::count_if(link.commands.begin(), link.commands.end(), [](const Command& command) {
        return command.state == CommandState::kQueued;
      });
  if (static_cast<size_t>(num_queued) >= kLimits.links.max_num_queued_commands) {
    throw ApiError("TooManyRequests", "too many commands wait for link " + id);
  }
  Command command{
      NewId("c"), request, link.report.run, now, Rfc3339(NowUs()), CommandState::kQueued, {}};
  link.commands.push_back(std::move(command));
  if (link.commands.size() > kLimits.links.max_num_commands) link.commands.pop_front();
  return JsonOf(link.commands.back());
}

LinkBoard::Link& LinkBoard::Existing(const std::string& id) {
  const auto found = links_.find(id);
  if (found == links_.end()) throw ApiError("NoSuchLink", "there is no such link");
  return found->second;
}

void LinkBoard::MakeRoom(LinkTime now) {
  if (links_.size() < kLimits.links.max_num_links) return;
  const auto oldest =
      std::min_element(links_.begin(), links_.end(), [](const auto& a, const auto& b) {
        return a.second.heard_at < b.second.heard_at;
      });
  if (IsHeard(oldest->second.heard_at, now)) {
    throw ApiError("TooManyLinks",
                   std::to_string(kLimits.links.max_num_links) + " links report already");
  }
  links_.erase(oldest);
}

void LinkBoard::Expire(Link& link, LinkTime now) {
  for (Command& command : link.commands) {
    const bool is_late = now - command.issued_at > kCommandHoldsFor;
    const bool is_for_another_run = command.run != link.report.run;
    if (command.state != CommandState::kQueued || !(is_late || is_for_another_run)) continue;
    command.state = CommandState::kExpired;
    command.detail =
        is_late ? "the link did not take it within 10 s" : "the link's program was started again";
  }
  std::erase_if(link.commands,
                [now](const Command& each) { return now - each.issued_at > kCommandKeptFor; });
}

// A report may be older than one that was handled before it, so a state never goes back.
void LinkBoard::TakeOutcomes(Link& link) {
  for (const CommandReport& outcome : link.report.commands) {
    for (Command& command : link.commands) {
      const bool is_it = command.id == outcome.id && command.run == link.report.run;
      if (!is_it || command.state >= CommandState::kDone || outcome.state < command.state) continue;
      command.state = outcome.state;
      command.detail = outcome.detail;
    }
  }
}

nlohmann::json LinkBoard::JsonOf(const Command& command) {
  nlohmann::json object{{"id", command.id},
                        {"kind", command.request.kind},
                        {"issued_at", command.issued_at_text},
                        {"state", NameOf(command.state)}};
  if (!command.request.site_id.empty()) object["site_id"] = command.request.site_id;
  if (const auto& wind = command.request.wind_in_world) {
    object["wind"] = {{"east_mps", wind->x()}, {"north_mps", wind->y()}};
  }
  if (!command.request.confirmed_by.empty()) {
    object["confirmed_by"] = command.request.confirmed_by;
  }
  if (!command.detail.empty()) object["detail"] = command.detail;
  return object;
}

nlohmann::json LinkBoard::JsonOf(const std::string& id, const Link& link, LinkTime now) {
  nlohmann::json object = link.report.state;
  const double heard_age_s = SecondsBetween(link.heard_at, now);
  object["id"] = id;
  object["heard_age_s"] = heard_age_s;
  object["is_connected"] = link.report.is_connected && IsHeard(link.heard_at, now);
  AddAge(heard_age_s, object);
  for (const char* const name : {"position", "wind"}) {
    if (const auto part = object.find(name); part != object.end()) AddAge(heard_age_s, *part);
  }
  object["commands"] = nlohmann::json::array();
  for (const Command& command : link.commands) object["commands"].push_back(JsonOf(command));
  return object;
}

}  // namespace freelsd
