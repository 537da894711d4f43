#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/layers/layers.h"
#include "api/stored/stored.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"

namespace freelsd {
namespace {

// Checks the layer's name first: an unknown name is NoSuchLayer, even if the site has no map.
SiteMap ExistingMap(const Service& service, const Call& call, const SiteRow& site) {
  const std::vector<std::string> names = LayerNames();
  if (std::find(names.begin(), names.end(), call.Id("layer")) == names.end()) {
    throw ApiError("NoSuchLayer", "there is no such layer");
  }
  std::optional<SiteMap> map = MapOf(service, site);
  if (!map) throw ApiError("NoMap", "the site has no map");
  return *std::move(map);
}

}  // namespace

void GetLayers(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  nlohmann::json layers{{"layers", nlohmann::json::array()}};
  if (const std::optional<SiteMap> map = MapOf(service, site)) {
    layers = LayersJson(*map, LocalFrame(ParseReplan(site.replan_json).origin));
  }
  response.set_content(layers.dump(), "application/json");
}

void GetLayerPicture(Service& service, const Call& call, httplib::Response& response) {
  const LongPlace place(service.long_queues.plans, WantedBy(service, call));
  const SiteMap map = ExistingMap(service, call, ExistingSite(service, call));
  response.set_content(LayerPng(map, call.Id("layer")), "image/png");
}

void GetLayerGeoTiff(Service& service, const Call& call, httplib::Response& response) {
  const LongPlace place(service.long_queues.plans, WantedBy(service, call));
  const SiteRow site = ExistingSite(service, call);
  const SiteMap map = ExistingMap(service, call, site);
  const LocalFrame local_frame(ParseReplan(site.replan_json).origin);
  response.set_content(LayerGeoTiff(map, call.Id("layer"), local_frame), "image/tiff");
}

void GetLayerLegend(Service& service, const Call& call, httplib::Response& response) {
  const SiteMap map = ExistingMap(service, call, ExistingSite(service, call));
  response.set_content(LegendPng(map, call.Id("layer")), "image/png");
}

}  // namespace freelsd
