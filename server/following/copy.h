// How old a follower's copy is.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "storage/storage.h"

namespace freelsd {

// Thread-safe. Empty unless this server follows another one.
class Copy {
 public:
  // `of`: address of the followed server.
  void Begin(const std::string& of, const BoundingBox& area, std::optional<int64_t> in_step_at_us);
  void SetInStep(int64_t at_us);
  // What was made here and is not known there yet.
  void SetNumUnsent(size_t num);
  // The followed server answers, or why not.
  void SetLink(const std::string& failure);

  bool IsThere() const;
  // {of, area, num_unsent, age_s?, link_failure?}; null if this server follows nobody. Without
  // age_s it was never in step.
  nlohmann::json Json(int64_t now_us) const;
  // Adds the copy to an answer of recall, and a warning with its age.
  void AddTo(nlohmann::json& answer, int64_t now_us) const;
  std::optional<double> AgeS(int64_t now_us) const;

 private:
  // Guards the other members.
  mutable std::mutex mutex_;
  std::string of_;
  BoundingBox area_{};
  std::optional<int64_t> in_step_at_us_;
  size_t num_unsent_ = 0;
  std::string link_failure_;
};

}  // namespace freelsd
