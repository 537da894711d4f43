#include "server/recall/superseding.h"

#include <cmath>

#include <spdlog/spdlog.h>

#include "server/recall/replan.h"

namespace freelsd {
namespace {

// Half the side of the box in which sites on the same ground have their touchdown.
constexpr double kNeighbourhoodDeg = 0.02;

// True if the centre of one region lies within the other region.
bool IsSameGround(const Replan& a, const Replan& b) {
  const LocalFrame frame_a(a.origin);
  const LocalFrame frame_b(b.origin);
  const auto holds = [](const Replan& outer,
                        const LocalFrame& outer_frame,
                        const Replan& inner,
                        const LocalFrame& inner_frame) {
    const Eigen::Vector2d center = Centroid(inner.request.footprint);
    const GeoPoint place = inner_frame.GeoFromWorld({center.x(), center.y(), 0.0});
    return Contains(outer.request.footprint, outer_frame.WorldFromGeo(place).head<2>());
  };
  return holds(a, frame_a, b, frame_b) || holds(b, frame_b, a, frame_a);
}

// Nothing if the row is invalid by current rules; recall cannot use it either.
std::optional<Replan> UsableReplan(const SiteRow& site) {
  try {
    return ParseReplan(site.replan_json);
  } catch (const std::exception& error) {
    spdlog::error("site {} cannot be used: {}", site.id, error.what());
    return std::nullopt;
  }
}

// Sites of other flights on the same ground.
std::vector<SiteRow> OnSameGround(const Storage& storage, const SiteRow& site) {
  const std::optional<Replan> replan = UsableReplan(site);
  if (!replan) return {};
  const BoundingBox box{std::remainder(site.longitude_deg - kNeighbourhoodDeg, 360.0),
                        site.latitude_deg - kNeighbourhoodDeg,
                        std::remainder(site.longitude_deg + kNeighbourhoodDeg, 360.0),
                        site.latitude_deg + kNeighbourhoodDeg};
  std::vector<SiteRow> same;
  for (SiteRow& other : storage.sites.List(std::nullopt, box)) {
    if (other.flight_id == site.flight_id) continue;
    const std::optional<Replan> other_replan = UsableReplan(other);
    if (other_replan && IsSameGround(*replan, *other_replan)) same.push_back(std::move(other));
  }
  return same;
}

// The site with the newest evidence after `after_us`; nullptr if there is none.
const SiteRow* NewestEvidence(const std::vector<SiteRow>& sites, int64_t after_us) {
  const SiteRow* newest = nullptr;
  for (const SiteRow& site : sites) {
    if (!site.is_evidence || site.seen_at_us <= after_us) continue;
    newest = &site;
    after_us = site.seen_at_us;
  }
  return newest;
}

std::optional<std::string> IdOf(const SiteRow* site) {
  return site == nullptr ? std::nullopt : std::optional(site->id);
}

}  // namespace

Standing StandingOf(const Storage& storage, const SiteRow& site) {
  const std::vector<SiteRow> same = OnSameGround(storage, site);
  Standing standing;
  for (const SiteRow& other : same) {
    if (site.is_evidence && other.seen_at_us <= site.seen_at_us) {
      standing.supersedes.push_back(other.id);
    }
  }
  standing.superseded_by = IdOf(NewestEvidence(same, site.seen_at_us));
  return standing;
}

bool ForgetSite(Storage& storage, const std::string& site_id) {
  const std::optional<SiteRow> site = storage.sites.Find(site_id);
  if (!site) return false;
  std::vector<SiteRow> superseded = OnSameGround(storage, *site);
  std::erase_if(superseded,
                [&site_id](const SiteRow& other) { return other.superseded_by != site_id; });
  // Updated before the site is deleted, so that recall never returns one of them in between.
  for (const SiteRow& other : superseded) {
    std::vector<SiteRow> others = OnSameGround(storage, other);
    std::erase_if(others, [&site_id](const SiteRow& third) { return third.id == site_id; });
    // Minus 1: a site photographed at the same time supersedes too, because it may have come later.
    storage.sites.SetSupersededBy(other.id, IdOf(NewestEvidence(others, other.seen_at_us - 1)));
  }
  return storage.sites.Delete(site_id);
}

}  // namespace freelsd
