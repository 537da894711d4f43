// The feed of changes: the last change of each site, map in force and obstacle, for servers that
// follow this one, and what a follower keeps of the server that it follows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "storage/site_store.h"

namespace freelsd {

enum class ChangeSubject { kSite, kMap, kObstacle };

enum class ChangeKind { kStored, kUpdated, kSuperseded, kConfirmed, kRemoved, kExpired };
inline bool IsRemoval(ChangeKind kind) {
  return kind == ChangeKind::kRemoved || kind == ChangeKind::kExpired;
}

// What has changed: a site, a map of a flight, or an obstacle.
struct ChangeKey {
  ChangeSubject subject = ChangeSubject::kSite;
  std::string id;

  auto operator<=>(const ChangeKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

// Its last change. A removed one keeps its row until ForgetRemoved.
struct ChangeRow {
  ChangeKey key;
  // Increases with every change of anything, in the order of the commits.
  int64_t number = 0;
  ChangeKind kind = ChangeKind::kStored;
  int64_t changed_at_us = 0;
  // updated_at_us of the row; if it was removed, of the row that was removed.
  int64_t stamp_us = 0;
  // Feed of the server that has made it. Empty: this one's.
  std::string origin = {};
  // Whether the server that this one follows has it as it is.
  bool is_known_above = false;
};

// Sites that touch down in one box, maps and obstacles that meet the other.
struct ChangeArea {
  BoundingBox sites{};
  BoundingBox surroundings{};
};

struct ChangePage {
  // By number.
  std::vector<ChangeRow> changes;
  // Of the last change that was looked at.
  int64_t last_number = 0;
  bool has_more = false;
};

// What a follower knows of the server that it follows.
struct FollowState {
  // Address and area. Another one begins anew.
  std::string followed;
  // Where to go on in its feed.
  std::string next;
  // When this copy was last in step.
  std::optional<int64_t> in_step_at_us;
};

// Invariant: a change has its number in the same commit as the row that changes. An area also gives
// what has left it.
class ChangeStore {
 public:
  virtual ~ChangeStore() = default;
  ChangeStore(const ChangeStore&) = delete;
  ChangeStore& operator=(const ChangeStore&) = delete;

  // Random. Numbers of a feed with another id mean something else.
  virtual std::string FeedId() const = 0;
  virtual int64_t LastNumber() const = 0;
  // Removals up to this number may be forgotten.
  virtual int64_t ForgottenThrough() const = 0;
  // Changes after that number, at most `limit`.
  virtual ChangePage List(int64_t after_number,
                          size_t limit,
                          const std::optional<ChangeArea>& area) const = 0;
  virtual std::optional<ChangeRow> Find(const ChangeKey& key) const = 0;
  // Gives each of them a new number, so that followers get it again.
  virtual void Repeat(const std::vector<ChangeKey>& keys) = 0;
  // Where the origin changes, followers get the change again.
  virtual void SetOrigins(const std::vector<ChangeRow>& changes) = 0;
  // Keeps the removal of something that is not here, or was removed with an earlier stamp.
  virtual void PutRemoval(const ChangeRow& removal) = 0;
  // Forgets what was removed before that time.
  virtual void ForgetRemoved(int64_t before_us) = 0;

  // Changes that the followed server does not know, by number.
  virtual std::vector<ChangeRow> ListUnknownAbove(size_t limit) const = 0;
  // Of those that have not changed since they had these numbers.
  virtual void SetKnownAbove(const std::vector<ChangeRow>& changes) = 0;
  // The followed server lost its memory: it knows nothing, but what had its own origin is gone.
  virtual void SetAllUnknownAbove(const std::string& except_origin) = 0;
  virtual std::optional<FollowState> FindFollowState() const = 0;
  virtual void PutFollowState(const FollowState& state) = 0;

 protected:
  ChangeStore() = default;
};

}  // namespace freelsd
