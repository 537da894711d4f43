// Selects and orders the stored sites that recall evaluates. Uses only positions and stored data,
// no maps.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/glide/glide.h"
#include "server/recall/altitude_datum.h"
#include "server/recall/recall_sites.h"

namespace freelsd {

// Radius of the largest search; no small plane glides farther.
constexpr double kMaxReachM = 100000.0;

// A site's score halves in this time, because ground changes.
constexpr double kScoreHalfLifeS = 365.0 * 24.0 * 3600.0;
// Time since the ground was last photographed, seconds. 0 for a time in the future; nothing if
// seen_at_us is 0, an unknown time.
std::optional<double> GroundAgeS(int64_t seen_at_us, int64_t now_us);
// {last_seen_at, age_s}; both are null if the time is unknown.
nlohmann::json GroundAgeJson(int64_t seen_at_us, int64_t now_us);
// The share of a score that is left at this age of the ground. None at an unknown age.
double ScoreLeft(const std::optional<double>& age_s);

// An aircraft without power, and a text that differs from aircraft to aircraft.
struct GlidingAircraft {
  Aircraft aircraft;
  std::string key;
  StraightGlide glide;
};

// The aircraft of stored sites without power, for requests with the same aircraft and glide ratio.
// Thread-safe.
class GlidingFleet {
 public:
  // See AircraftOf. Null if the stored aircraft is invalid by current rules.
  std::shared_ptr<const GlidingAircraft> Of(const EmergencyRequest& request,
                                            const std::string& aircraft_json);

 private:
  // Guards gliding_.
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const GlidingAircraft>> gliding_;
};

// A stored site as seen from the aircraft. Lengths and margins are in metres.
struct RecallCandidate {
  const RecallRow* row = nullptr;
  // The request's aircraft, or the one that the site was planned for.
  std::shared_ptr<const GlidingAircraft> gliding;
  // From the aircraft to the site: east, north.
  Eigen::Vector2d way_m = Eigen::Vector2d::Zero();
  double distance_m = 0.0;
  DatumDifference datum;
  double score = 0.0;
  // Empty: unknown. It ranks behind any known age.
  std::optional<double> age_s;
  // Upper bound of the arrival margin: the height on arrival above the start of the final.
  double best_margin_m = 0.0;
  // Estimate of the arrival margin, for a glide straight to the site.
  double expected_margin_m = 0.0;
};

BoundingBox BoxAround(const GeoPoint& place, double reach_m);
GlideStart StartOf(const EmergencyRequest& request, const Eigen::Vector3d& position_in_world);
// The aircraft without power. Aircraft and glide ratio of the request override those of the site.
// Nothing if the stored aircraft is invalid by current rules.
std::optional<Aircraft> AircraftOf(const EmergencyRequest& request,
                                   const std::string& aircraft_json);
// The request's aircraft without power; else, of those that stored sites were planned for, the one
// that glides least far.
Aircraft LeastGlidingAircraft(const EmergencyRequest& request, const RecallBounds& bounds);
// Upper bound of the gliding distance: the distance to the altitude of the lowest site, with the
// aircraft that glides farthest.
double GreatestReach(const EmergencyRequest& request,
                     const RecallBounds& bounds,
                     GlidingFleet& fleet);

// In no order. Candidates point into `rows`. Sites whose stored aircraft is invalid are left out.
std::vector<RecallCandidate> Candidates(const EmergencyRequest& request,
                                        const SharedRows<RecallRow>& rows,
                                        GlidingFleet& fleet);
// Moves the `num` most promising candidates from `begin` on to `begin`, in order. Only those behind
// are moved. Candidates out of reach come last.
void SortNext(std::vector<RecallCandidate>& candidates, size_t begin, size_t num);

// What planning tells of a candidate's rank.
struct PlannedRank {
  // Another map doubts the site or this plan of it.
  bool is_doubted = false;
  double margin_m = 0.0;
  bool is_landable = false;
};

// True if the candidate cannot rank before `reached`, which is an evaluated site in reach. For the
// candidate the best case is assumed: its plan is landable, and its margin is best_margin_m.
bool IsSurelyNotBetter(const RecallCandidate& candidate,
                       const PlannedRank& rank_of_reached,
                       const RecallCandidate& reached);

// True if site `a` ranks before site `b` in an answer. What another map doubts comes last. The
// order is by arrival margin (in steps), then verdict, then score (reduced with age), then age,
// then the score when stored, then distance.
bool IsBetter(const PlannedRank& rank_a,
              const RecallCandidate& a,
              const PlannedRank& rank_b,
              const RecallCandidate& b);

// --- Sites of an experiment: a flight whose memory is "none" ---

inline constexpr const char* kExperimentWarning =
    "Of an experiment (memory: none): its options may not be those that were tested, and no other "
    "flight recalls it.";

// As it is stored: a site of an experiment has no recall data, and its feature says so.
SiteRow AsRemembered(SiteRow site, const FlightMemory& memory);

// Whether the request finds the site only because both are of the same experiment.
bool IsOwnExperiment(const EmergencyRequest& request, const RecallRow& site);
// Empty unless the request is of an experiment.
SharedRows<RecallRow> OwnSites(const Storage& storage, const EmergencyRequest& request);
// Bounds that hold for these sites too.
RecallBounds WithSites(RecallBounds bounds, const SharedRows<RecallRow>& sites);

}  // namespace freelsd
