#include "server/following/follower.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "api/api.h"
#include "api/import/import.h"
#include "server/config.h"
#include "server/following/feed.h"
#include "server/following/told_map.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr int kWaitS = 5;
constexpr std::chrono::milliseconds kShortWait{1000};
constexpr double kEarlyPauseS = 0.25;
constexpr int kConnectS = 5;
constexpr int kAnswerS = 20;
constexpr double kFirstPauseS = 0.5;
constexpr double kLongestPauseS = 30.0;
// Its token, or what it refused, may have been mended meanwhile.
constexpr std::chrono::minutes kRefusedFor{10};
constexpr size_t kMaxNumPushed = 100;
constexpr size_t kMaxNumListed = 20000;
constexpr size_t kMaxPushedBytes = size_t{4} << 20;
// How often the time at which the copy was in step is written, if nothing else is.
constexpr int64_t kRememberPeriodUs = 60'000'000;

// The followed server cannot be reached, or answers something else. Tried again later.
struct LinkFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// "scheme://host:port" of a URL, and its path.
std::pair<std::string, std::string> PartsOf(const std::string& url) {
  const size_t host = url.find("://") + 3;
  const size_t path = std::min(url.find('/', host), url.size());
  std::string prefix = url.substr(path);
  while (prefix.ends_with('/')) prefix.pop_back();
  return {url.substr(0, path), prefix};
}

nlohmann::json ParseAnswer(const std::string& body) {
  nlohmann::json answer = nlohmann::json::parse(body, nullptr, false);
  if (answer.is_discarded() || !answer.is_object()) throw LinkFailure("the answer is no JSON");
  return answer;
}

const httplib::Response& Expect2xx(const httplib::Result& result) {
  if (!result) throw LinkFailure(httplib::to_string(result.error()));
  if (result->status >= 200 && result->status < 300) return *result;
  throw LinkFailure("it answers " + std::to_string(result->status) + ": " +
                    result->body.substr(0, 200));
}

// Obstacles and maps before the sites that need them; removals last.
bool IsSentBefore(const ChangeRow& a, const ChangeRow& b) {
  const auto order = [](const ChangeRow& change) {
    return std::tuple(IsRemoval(change.kind), -static_cast<int>(change.key.subject), change.number);
  };
  return order(a) < order(b);
}

// A site that cannot be read counts as gone: what is known of it here is out of date. Without an
// obstacle or a map sites would look safe, so the copy stays behind until it can be read.
ToldChange ReadChange(const nlohmann::json& change) {
  try {
    return ParseTold(change, "/changes");
  } catch (const ApiError& error) {
    const std::string what = std::string("a change that was told cannot be used: ") + error.what();
    if (!change.is_object() || change.value("subject", "") != "site") throw LinkFailure(what);
    spdlog::error(what);
  }
  ToldChange gone;
  gone.change.key = {ChangeSubject::kSite, change.value("id", "")};
  gone.has_left = true;
  return gone;
}

}  // namespace

BoundingBox ParseArea(const std::string& text) {
  const std::vector<double> sides = ParseQueryNumbers(text, "bbox");
  const bool is_box = sides.size() == 4 && std::abs(sides[0]) <= 180 && std::abs(sides[2]) <= 180 &&
                      sides[1] >= -90 && sides[1] <= sides[3] && sides[3] <= 90;
  if (is_box) return {sides[0], sides[1], sides[2], sides[3]};
  const std::string detail = "bbox: must be west,south,east,north in degrees";
  throw ApiError("InvalidQuery", detail, {{"bbox", detail}});
}

std::string ReadFollowToken(const std::filesystem::path& path) {
  constexpr auto kOthers = std::filesystem::perms::group_all | std::filesystem::perms::others_all;
  std::ifstream file(path);
  std::string token;
  if (!std::getline(file, token) || token.empty()) {
    throw ConfigError("--follow-token-file: " + path.string() + " cannot be read, or is empty");
  }
  const auto permissions = std::filesystem::status(path).permissions();
  if ((permissions & kOthers) == std::filesystem::perms::none) return token;
  throw ConfigError("--follow-token-file: " + path.string() +
                    " can be read by others; allow its owner alone (chmod 600)");
}

Follower::Follower(Storage& storage,
                   MapCache& maps,
                   Copy& copy,
                   FollowOptions options,
                   std::function<void(const MergeResult&)> on_merged)
    : storage_(storage),
      maps_(maps),
      copy_(copy),
      options_(std::move(options)),
      on_merged_(std::move(on_merged)),
      path_prefix_(PartsOf(options_.url).second),
      client_(PartsOf(options_.url).first) {
  client_.set_connection_timeout(kConnectS);
  client_.set_read_timeout(kWaitS + kAnswerS);
  client_.set_write_timeout(kAnswerS);
  client_.set_keep_alive(true);
  client_.set_tcp_nodelay(true);
  if (!options_.token.empty()) client_.set_bearer_token_auth(options_.token);
  const std::string followed = options_.url + " " + options_.area_text;
  const std::optional<FollowState> known = storage_.changes.FindFollowState();
  state_ = known && known->followed == followed ? *known : FollowState{followed, "", {}};
  // Another server knows nothing of what the former one was sent.
  if (known && known->followed != followed && !known->next.empty()) {
    storage_.changes.SetAllUnknownAbove(ParseFeedPlace(known->next).feed);
  }
  is_anew_ = state_.next.empty();
  copy_.Begin(options_.url, options_.area, state_.in_step_at_us);
}

Follower::~Follower() { Stop(); }

void Follower::Start() {
  thread_ = std::thread([this] { Run(); });
}

void Follower::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  stopping_.notify_all();
  client_.stop();
  if (thread_.joinable()) thread_.join();
}

bool Follower::Pause(double seconds) {
  std::unique_lock lock(mutex_);
  return !stopping_.wait_for(
      lock, std::chrono::duration<double>(seconds), [this] { return is_stopping_; });
}

void Follower::Run() {
  double pause_s = kFirstPauseS;
  while (Pause(0.0)) {
    try {
      KeepInStep();
      pause_s = kFirstPauseS;
      continue;
    } catch (const LinkFailure& failure) {
      copy_.SetLink(failure.what());
      spdlog::warn("{} is not followed now: {}", options_.url, failure.what());
    } catch (const std::exception& error) {
      copy_.SetLink(error.what());
      spdlog::error("following {}: {}", options_.url, error.what());
    }
    if (!Pause(pause_s)) return;
    pause_s = std::min(2.0 * pause_s, kLongestPauseS);
  }
}

void Follower::KeepInStep() {
  while (Pull(0)) {
    if (!Pause(0.0)) return;
  }
  // What the other one has new comes before the next portion.
  if (Push()) return;
  const auto begin = std::chrono::steady_clock::now();
  const bool has_more = Pull(kWaitS);
  // It has too many clients that wait, or something has changed.
  const bool is_early = std::chrono::steady_clock::now() - begin < kShortWait;
  if (!has_more && is_early) Pause(kEarlyPauseS);
}

nlohmann::json Follower::AskForPage(const std::string& since,
                                    const std::string& subjects,
                                    int wait_s) {
  httplib::Params query{
      {"since", since}, {"bbox", options_.area_text}, {"wait_s", std::to_string(wait_s)}};
  if (!subjects.empty()) query.emplace("subjects", subjects);
  nlohmann::json page = ParseAnswer(
      Expect2xx(client_.Get(httplib::append_query_params(path_prefix_ + "/v1/changes", query)))
          .body);
  if (page.contains("changes") && page.contains("next") && page.contains("has_more")) return page;
  throw LinkFailure("the answer is no page of changes");
}

bool Follower::Pull(int wait_s) {
  const int64_t asked_at_us = NowUs();
  const std::string since = state_.next.empty() ? "0" : state_.next;
  const nlohmann::json page = AskForPage(since, "", wait_s);
  if (page.contains("begin_anew")) {
    BeginAnew(page["begin_anew"].get<std::string>());
    return true;
  }
  const bool has_more = page["has_more"].get<bool>();
  if (has_more && !has_ground_) PullGround(since);
  has_ground_ = has_more;
  TakePage(page["changes"]);
  state_.next = page["next"].get<std::string>();
  if (!has_more && is_anew_) EndPass();
  if (!page["changes"].empty()) remembered_at_us_ = 0;
  Remember(!has_more, asked_at_us);
  copy_.SetLink("");
  // The next change cannot be read at this moment.
  if (has_more && page["changes"].empty()) Pause(kEarlyPauseS);
  return has_more;
}

void Follower::PullGround(std::string since) {
  bool has_more = true;
  while (has_more && Pause(0.0)) {
    const nlohmann::json page = AskForPage(since, "map,obstacle", 0);
    if (page.contains("begin_anew")) throw LinkFailure("the feed has changed");
    TakePage(page["changes"]);
    since = page["next"].get<std::string>();
    has_more = page["has_more"].get<bool>();
  }
  if (has_more) throw LinkFailure("this server is stopping");
}

void Follower::EndPass() {
  RemoveUntold(storage_, maps_, told_, options_.area);
  is_anew_ = false;
  told_.clear();
  remembered_at_us_ = 0;
}

void Follower::Remember(bool is_in_step, int64_t asked_at_us) {
  if (is_in_step) {
    state_.in_step_at_us = asked_at_us;
    copy_.SetInStep(asked_at_us);
  }
  // A pass from the beginning is not gone on with after a start: what was told before is forgotten.
  if (is_anew_ || asked_at_us - remembered_at_us_ < kRememberPeriodUs) return;
  storage_.changes.PutFollowState(state_);
  remembered_at_us_ = asked_at_us;
}

void Follower::BeginAnew(const std::string& why) {
  spdlog::warn("{} is followed from the beginning: {}", options_.url, why);
  // It lost its memory, and with it what it was sent.
  if (why == "other_feed" && !state_.next.empty()) {
    storage_.changes.SetAllUnknownAbove(ParseFeedPlace(state_.next).feed);
  }
  state_.next.clear();
  is_anew_ = true;
  has_ground_ = false;
  told_.clear();
  storage_.changes.PutFollowState(state_);
}

void Follower::TakePage(const nlohmann::json& page) {
  std::vector<ToldChange> changes;
  for (const nlohmann::json& each : page) {
    changes.push_back(ReadChange(each));
  }
  if (changes.empty()) return;
  FetchMaps(changes);
  const MergeResult merged = MergeFromAbove(storage_, maps_, changes);
  if (is_anew_) {
    for (const ToldChange& told : changes) {
      if (!told.IsRemoval() && !told.has_left) told_.push_back(told.change.key);
    }
  }
  if (merged.num_taken > 0) on_merged_(merged);
}

void Follower::FetchMaps(const std::vector<ToldChange>& changes) {
  for (const std::string& id : MapsToFetch(storage_, changes)) {
    const httplib::Result result = client_.Get(path_prefix_ + "/v1/maps/" + id);
    // Removed meanwhile: what lies on it was told with a later number.
    if (result && result->status == 404 && result->body.find("\"NoMap\"") != std::string::npos) {
      continue;
    }
    const std::string& bytes = Expect2xx(result).body;
    if (result->get_header_value("ETag") != "\"" + Sha256Hex(bytes) + "\"") {
      throw LinkFailure("the bytes of map " + id + " do not match their digest");
    }
    const TakenMap taken = ParseMapBytes(bytes, id);
    storage_.maps.Stage(taken.map, taken.tiles, {});
  }
}

bool Follower::Push() {
  std::vector<ChangeRow> unknown = storage_.changes.ListUnknownAbove(kMaxNumListed);
  copy_.SetNumUnsent(unknown.size());
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(refused_, [&](const auto& each) { return now - each.second > kRefusedFor; });
  std::erase_if(unknown, [&](const ChangeRow& each) { return refused_.contains(each.number); });
  if (unknown.empty()) return false;
  std::sort(unknown.begin(), unknown.end(), IsSentBefore);
  unknown.resize(std::min(unknown.size(), kMaxNumPushed));
  // What changes just now is sent as it is then.
  std::erase_if(unknown, [this](const ChangeRow& each) { return !ReadTold(storage_, each); });
  if (unknown.empty()) return false;
  Send(unknown);
  return true;
}

void Follower::Send(const std::vector<ChangeRow>& changes) {
  const std::string feed = storage_.changes.FeedId();
  nlohmann::json body{{"changes", nlohmann::json::array()}};
  std::vector<ChangeRow> sent;
  size_t num_bytes = 0;
  for (const ChangeRow& change : changes) {
    if (num_bytes > kMaxPushedBytes) break;
    const std::optional<ToldChange> told = ReadTold(storage_, change);
    // It changes just now, and is sent as it is then.
    if (!told) continue;
    sent.push_back(change);
    body["changes"].push_back(ToldJson(*told, feed));
    num_bytes += body["changes"].back().dump().size();
  }
  if (sent.empty()) return;
  httplib::Result result = Post(body);
  if (result && result->status == 409) {
    SendMaps(ParseAnswer(result->body));
    result = Post(body);
  }
  if (result && (result->status == 401 || result->status == 403)) {
    spdlog::error("{} takes nothing from here: its token needs the scope admin", options_.url);
    Refuse(sent);
    return;
  }
  // 409: of several changes, one whose map cannot be told holds back no other.
  if (result && (result->status == 409 || result->status == 413 || result->status == 422)) {
    if (sent.size() > 1) {
      for (const ChangeRow& change : sent) Send({change});
      return;
    }
    spdlog::error("{} refuses {}: {}", options_.url, sent[0].key.id, result->body);
    Refuse(sent);
    return;
  }
  Expect2xx(result);
  storage_.changes.SetKnownAbove(sent);
}

void Follower::Refuse(const std::vector<ChangeRow>& changes) {
  const auto now = std::chrono::steady_clock::now();
  for (const ChangeRow& change : changes) refused_[change.number] = now;
}

httplib::Result Follower::Post(const nlohmann::json& body) {
  httplib::Result result =
      client_.Post(path_prefix_ + "/v1/changes", body.dump(), "application/json");
  const bool is_conflict = result && result->status == 409;
  if (is_conflict && ParseAnswer(result->body).value("code", "") != "MapMissing") Expect2xx(result);
  return result;
}

void Follower::SendMaps(const nlohmann::json& problem) {
  std::set<std::string> ids;
  for (const nlohmann::json& each : problem.value("errors", nlohmann::json::array())) {
    ids.insert(each.value("detail", ""));
  }
  for (const std::string& id : ids) {
    const std::optional<FlightMapRow> map = storage_.maps.Find(id);
    // Replaced meanwhile: the change is sent as it is then.
    if (!map) continue;
    Expect2xx(client_.Put(
        path_prefix_ + "/v1/maps/" + id, MapBytes(storage_, *map), "application/octet-stream"));
  }
}

}  // namespace freelsd
