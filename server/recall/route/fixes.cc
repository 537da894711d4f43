#include "server/recall/route/fixes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/recall/route/look.h"

namespace freelsd {
namespace {

constexpr std::array kClimbsM{25.0, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0};
// To either side.
constexpr std::array kOffsetsM{100.0, 200.0, 300.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0};
constexpr size_t kMaxNumGapsWithFixes = 6;
// Moments looked at to compare changes none of which closes the gap.
constexpr size_t kNumCompared = 24;
// A gap of which more than this share is left counts as not helped.
constexpr double kMaxLeftRatio = 0.5;

struct Candidate {
  FixKind kind = FixKind::kClimb;
  double amount_m = 0.0;
  RouteChange change;
};

// Middle first, then quarters, and so on: a moment that spoils a change is found soon.
std::vector<size_t> FromMiddle(size_t size) {
  std::vector<size_t> order;
  for (size_t step = size; step > 0; step /= 2) {
    for (size_t i = step / 2; i < size; i += step) order.push_back(i);
    if (step == 1) break;
  }
  std::vector<bool> is_known(size, false);
  std::erase_if(order, [&](size_t i) {
    const bool known = is_known[i];
    is_known[i] = true;
    return known;
  });
  for (size_t i = 0; i < size; ++i) {
    if (!is_known[i]) order.push_back(i);
  }
  return order;
}

class FixSearch {
 public:
  FixSearch(const RouteJudge& judge, const RouteRequest& request, const Insurance& insurance)
      : judge_(judge), request_(request), insurance_(insurance) {}

  std::optional<RouteFix> Find(FixKind kind, size_t gap) const {
    const std::vector<Candidate> candidates = kind == FixKind::kClimb ? Climbs(gap) : Offsets(gap);
    const auto flown = std::find_if(candidates.begin(), candidates.end(), [&](const auto& each) {
      return ShareLeft(each, 0) == 0.0;
    });
    if (flown != candidates.end()) return FixOf(*flown, gap);
    return BestPart(candidates, gap);
  }

 private:
  const RouteGap& GapAt(size_t gap) const { return insurance_.gaps[gap]; }
  const RouteMoment& MomentAt(size_t i) const { return insurance_.moments[i].moment; }

  RouteChange ChangeAt(size_t gap) const {
    RouteChange change;
    change.from_m = MomentAt(GapAt(gap).first).distance_m;
    change.to_m = MomentAt(GapAt(gap).last).distance_m;
    const double gradient_deg = request_.aircraft.value_or(Aircraft{}).climb_gradient_deg;
    change.climb_slope = std::tan(RadFromDeg(gradient_deg));
    return change;
  }

  std::vector<Candidate> Climbs(size_t gap) const {
    std::vector<Candidate> candidates;
    for (const double climb_m : kClimbsM) {
      Candidate candidate{FixKind::kClimb, climb_m, ChangeAt(gap)};
      candidate.change.climb_m = climb_m;
      candidates.push_back(candidate);
    }
    return candidates;
  }

  // Square to the direction of travel in the middle of the gap.
  std::vector<Candidate> Offsets(size_t gap) const {
    const size_t middle = (GapAt(gap).first + GapAt(gap).last) / 2;
    const double right = RadFromDeg(MomentAt(middle).heading_deg + 90.0);
    std::vector<Candidate> candidates;
    for (const double offset_m : kOffsetsM) {
      for (const double sided_m : {offset_m, -offset_m}) {
        Candidate candidate{FixKind::kOffset, sided_m, ChangeAt(gap)};
        candidate.change.offset_m = sided_m * Eigen::Vector2d(std::sin(right), std::cos(right));
        candidates.push_back(candidate);
      }
    }
    return candidates;
  }

  std::vector<GeoPoint> RouteWith(const RouteChange& change) const {
    return Changed(request_.route, change, judge_.options());
  }

  // The moments that the change moves. Empty if the changed route cannot be flown.
  std::vector<RouteMoment> MovedMoments(const RouteChange& change) const {
    const ChangedPart part = PartOf(request_.route, change, judge_.options());
    std::vector<RouteMoment> moments;
    try {
      moments = judge_.MomentsOf(RouteWith(change));
    } catch (const ApiError&) {
      return {};
    }
    // A changed part is longer. Behind it, as much is left as before.
    const double length_m = moments.back().distance_m;
    const double old_length_m = insurance_.moments.back().moment.distance_m;
    const double end_m = part.end_m + length_m - old_length_m;
    std::erase_if(moments, [&](const RouteMoment& moment) {
      return moment.distance_m < part.begin_m || moment.distance_m > end_m;
    });
    return moments;
  }

  // Share of the moved moments that are not covered, of `num` of them. num = 0: 0 only if all are
  // covered, else 1.
  double ShareLeft(const Candidate& candidate, size_t num) const {
    const std::vector<RouteMoment> moments = MovedMoments(candidate.change);
    if (moments.empty()) return 1.0;
    std::vector<size_t> order = FromMiddle(moments.size());
    if (num > 0) order.resize(std::min(order.size(), num));
    size_t num_left = 0;
    for (const size_t i : order) {
      if (judge_.Judge(moments[i]).is_covered) continue;
      if (num == 0) return 1.0;
      ++num_left;
    }
    return static_cast<double>(num_left) / static_cast<double>(order.size());
  }

  std::optional<RouteFix> BestPart(const std::vector<Candidate>& candidates, size_t gap) const {
    const Candidate* best = nullptr;
    double least = 1.0;
    for (const Candidate& candidate : candidates) {
      const double share = ShareLeft(candidate, kNumCompared);
      if (share >= least) continue;
      least = share;
      best = &candidate;
    }
    if (best == nullptr) return std::nullopt;
    RouteFix fix = FixOf(*best, gap);
    const double period_s = judge_.options().moment_period_s;
    const auto gap_s = static_cast<double>(GapAt(gap).last - GapAt(gap).first + 1) * period_s;
    const double before_s = static_cast<double>(insurance_.NumUncovered()) * period_s;
    if (fix.gaps_left_s > before_s - (1.0 - kMaxLeftRatio) * gap_s) return std::nullopt;
    return fix;
  }

  RouteFix FixOf(const Candidate& candidate, size_t gap) const {
    RouteFix fix;
    fix.kind = candidate.kind;
    fix.gap = gap;
    (candidate.kind == FixKind::kClimb ? fix.climb_m : fix.offset_m) = candidate.amount_m;
    fix.route = RouteWith(candidate.change);
    fix.gaps_left_s = static_cast<double>(judge_.Insure(fix.route, insurance_).NumUncovered()) *
                      judge_.options().moment_period_s;
    return fix;
  }

  const RouteJudge& judge_;
  const RouteRequest& request_;
  const Insurance& insurance_;
};

// The longest first.
std::vector<size_t> LongestGaps(const std::vector<RouteGap>& gaps) {
  std::vector<size_t> order(gaps.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&gaps](size_t a, size_t b) {
    return gaps[a].last - gaps[a].first > gaps[b].last - gaps[b].first;
  });
  order.resize(std::min(order.size(), kMaxNumGapsWithFixes));
  return order;
}

}  // namespace

const char* NameOf(FixKind kind) {
  switch (kind) {
    case FixKind::kClimb:
      return "climb";
    case FixKind::kOffset:
      return "offset";
    case FixKind::kLook:
      break;
  }
  return "look";
}

FoundFixes FindFixes(const RouteJudge& judge,
                     const StoredSites& stored,
                     const RouteRequest& request,
                     const Insurance& insurance) {
  const FixSearch search(judge, request, insurance);
  std::vector<size_t> gaps = LongestGaps(insurance.gaps);
  std::sort(gaps.begin(), gaps.end());
  FoundFixes found;
  // What was found at the deadline counts moments that were not evaluated.
  const auto add = [&](std::optional<RouteFix> fix) {
    found.is_complete = found.is_complete && !judge.IsLate();
    if (fix && found.is_complete) found.fixes.push_back(std::move(*fix));
  };
  for (const size_t gap : gaps) {
    if (judge.IsLate()) break;
    add(search.Find(FixKind::kClimb, gap));
    add(search.Find(FixKind::kOffset, gap));
    add(LookFirst(judge, stored, request, insurance, gap));
  }
  found.is_complete = found.is_complete && !judge.IsLate();
  return found;
}

}  // namespace freelsd
