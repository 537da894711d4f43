#include "server/jobs/organisations/organisations.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace freelsd {
namespace {

// Of recall's memory that the organisation has. Each has enough for a site with its map.
CacheSizes CacheSizesOf(const Config& config, size_t num_organisations) {
  constexpr size_t kMinBytes = size_t{96} << 20;
  const size_t num_bytes =
      std::max(kMinBytes, (static_cast<size_t>(config.recall_cache_mib) << 20) / num_organisations);
  return {num_bytes / 2, num_bytes / 3, num_bytes / 6};
}

}  // namespace

Organisation::Organisation(const Config& config,
                           const std::string& name,
                           std::unique_ptr<Storage> opened,
                           const BaseMap& base_map,
                           size_t num_organisations,
                           LongQueues& long_queues)
    : storage(std::move(opened)),
      maps(CacheSizesOf(config, num_organisations)),
      intake(config, *storage, events),
      alternates(*storage, maps, events, static_cast<size_t>(config.num_alternates)),
      service(intake, maps, alternates, base_map, long_queues) {
  const auto settings = config.organisations.find(name);
  if (settings != config.organisations.end()) intake.quotas = settings->second.quotas;
  intake.on_new_pose = [this](const std::string& flight_id) { alternates.Wake(flight_id); };
}

Organisations::Organisations(const Config& config,
                             std::unique_ptr<Storage> storage,
                             const BaseMap& base_map)
    : config_(config),
      base_map_(base_map),
      num_organisations_(storage->claims.ListOrganisations().size()),
      default_(config,
               kDefaultOrganisation,
               std::move(storage),
               base_map,
               num_organisations_,
               long_queues_) {}

Organisations::~Organisations() = default;

void Organisations::CallWithEach(const Call& call) {
  const std::lock_guard lock(mutex_);
  call_ = call;
  call_(kDefaultOrganisation, default_);
  for (const auto& [name, organisation] : others_) call_(name, *organisation);
}

void Organisations::ForEach(const Call& call) {
  std::vector<std::pair<std::string, Organisation*>> open{{kDefaultOrganisation, &default_}};
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, organisation] : others_) open.emplace_back(name, organisation.get());
  }
  for (const auto& [name, organisation] : open) call(name, *organisation);
}

Organisation& Organisations::Opened(const std::string& name) {
  const auto found = others_.find(name);
  if (found != others_.end()) return *found->second;
  auto organisation = std::make_unique<Organisation>(config_,
                                                     name,
                                                     default_.storage->ForOrganisation(name),
                                                     base_map_,
                                                     num_organisations_,
                                                     long_queues_);
  call_(name, *organisation);
  return *(others_[name] = std::move(organisation));
}

Service& Organisations::Of(const std::string& name) {
  if (name == kDefaultOrganisation) return default_.service;
  const std::lock_guard lock(mutex_);
  return Opened(name).service;
}

Organisation* Organisations::Find(const std::string& name) {
  if (name == kDefaultOrganisation) return &default_;
  const std::lock_guard lock(mutex_);
  const auto found = others_.find(name);
  return found == others_.end() ? nullptr : found->second.get();
}

}  // namespace freelsd
