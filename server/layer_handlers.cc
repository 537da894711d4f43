#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/export/export.h"
#include "server/handlers.h"
#include "server/site_lookup.h"

namespace freelsd {
namespace {

// Checks the names first: a site without map has no such layer either way.
SiteMap ExistingMap(const Service& service, const Call& call, const SiteRow& site) {
  const std::vector<std::string> names = LayerNames();
  if (std::find(names.begin(), names.end(), call.Id("layer")) == names.end()) {
    throw ApiError("NoSuchLayer", "there is no such layer");
  }
  const std::optional<std::string> blob = service.storage.ReadSiteMap(site.id);
  if (!blob) throw ApiError("NoMap", "the site never had a map");
  return DeserializeSiteMap(*blob);
}

}  // namespace

void GetLayers(Service& service, const Call& call, httplib::Response& response) {
  const SiteRow site = ExistingSite(service, call);
  const std::optional<std::string> blob = service.storage.ReadSiteMap(site.id);
  nlohmann::json layers{{"layers", nlohmann::json::array()}};
  if (blob) {
    layers =
        LayersJson(DeserializeSiteMap(*blob), LocalFrame(ParseReplan(site.replan_json).origin));
  }
  response.set_content(layers.dump(), "application/json");
}

void GetLayerPicture(Service& service, const Call& call, httplib::Response& response) {
  const SiteMap map = ExistingMap(service, call, ExistingSite(service, call));
  response.set_content(LayerPng(map, call.Id("layer")), "image/png");
}

void GetLayerGeoTiff(Service& service, const Call& call, httplib::Response& response) {
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
