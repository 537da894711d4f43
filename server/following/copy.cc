#include "server/following/copy.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace freelsd {

void Copy::Begin(const std::string& of,
                 const BoundingBox& area,
                 std::optional<int64_t> in_step_at_us) {
  const std::lock_guard lock(mutex_);
  of_ = of;
  area_ = area;
  in_step_at_us_ = in_step_at_us;
}

void Copy::SetInStep(int64_t at_us) {
  const std::lock_guard lock(mutex_);
  in_step_at_us_ = at_us;
}

void Copy::SetNumUnsent(size_t num) {
  const std::lock_guard lock(mutex_);
  num_unsent_ = num;
}

void Copy::SetLink(const std::string& failure) {
  const std::lock_guard lock(mutex_);
  link_failure_ = failure;
}

bool Copy::IsThere() const {
  const std::lock_guard lock(mutex_);
  return !of_.empty();
}

std::optional<double> Copy::AgeS(int64_t now_us) const {
  const std::lock_guard lock(mutex_);
  // A clock that was set back knows no age.
  if (!in_step_at_us_ || now_us < *in_step_at_us_) return std::nullopt;
  return 1e-6 * static_cast<double>(now_us - *in_step_at_us_);
}

nlohmann::json Copy::Json(int64_t now_us) const {
  const std::optional<double> age_s = AgeS(now_us);
  const std::lock_guard lock(mutex_);
  if (of_.empty()) return nullptr;
  nlohmann::json copy{{"of", of_},
                      {"area", {area_.west_deg, area_.south_deg, area_.east_deg, area_.north_deg}},
                      {"num_unsent", num_unsent_}};
  if (age_s) copy["age_s"] = *age_s;
  if (!link_failure_.empty()) copy["link_failure"] = link_failure_;
  return copy;
}

void Copy::AddTo(nlohmann::json& answer, int64_t now_us) const {
  const nlohmann::json copy = Json(now_us);
  if (copy.is_null()) return;
  std::string warning = "answered from a copy of " + copy["of"].get<std::string>();
  warning += copy.contains("age_s")
                 ? ", " + std::to_string(std::lround(copy["age_s"].get<double>())) + " s old"
                 : ", whose age is not known";
  answer["copy"] = copy;
  answer["warnings"].push_back(warning + "; nothing newer, and nothing outside its area, is known");
}

}  // namespace freelsd
