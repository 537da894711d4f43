// Links to autopilots: what they report, and what a person asks of them.
#include <chrono>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/import/import.h"
#include "api/import/links/links.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

constexpr char kJson[] = "application/json";

LinkTime Now() { return std::chrono::steady_clock::now(); }

const std::string& LinkId(const Call& call) {
  const std::string& id = call.Id("link");
  if (!IsValidId(id)) throw ApiError("InvalidId", "the id must match [A-Za-z0-9._-]{1,128}");
  return id;
}

void Publish(Service& service,
             const std::string& link_id,
             const LinkReport& report,
             const std::vector<LinkDecision>& decisions) {
  for (const LinkDecision& decision : decisions) {
    const nlohmann::json data{{"link", link_id},
                              {"flight_id", report.flight_id},
                              {"run", report.run},
                              {"id", decision.number},
                              {"at", decision.at},
                              {"kind", decision.kind},
                              {"text", decision.text}};
    service.events.Publish("link", report.flight_id, data.dump());
  }
}

std::string BodyOf(const Call& call) { return call.body.ReadAll(kLimits.links.max_bytes); }

// Throws ApiError unless the site may be landed on, as far as is known now.
void RequireLandable(const Service& service, const std::string& site_id) {
  const std::optional<SiteRow> stored = service.storage.sites.Find(site_id);
  if (!stored) throw ApiError("NoSuchSite", "there is no such site", {{"/site_id", "unknown"}});
  if (stored->superseded_by && !stored->IsContested()) {
    throw ApiError("SiteSuperseded",
                   "the site is superseded by " + *stored->superseded_by,
                   {{"/site_id", "is superseded"}});
  }
  const SiteRow site = AsObstructed({service.storage, service.maps}, *stored);
  const nlohmann::json feature = nlohmann::json::parse(site.feature_json);
  if (feature["properties"].value("verdict", "rejected") == "rejected") {
    throw ApiError("SiteRejected", "the site is rejected", {{"/site_id", "is rejected"}});
  }
  if (site.approach_json.empty()) {
    throw ApiError("NoApproach", "the site has no approach", {{"/site_id", "has no approach"}});
  }
}

void Queue(Service& service,
           const Call& call,
           const CommandRequest& request,
           httplib::Response& response) {
  const nlohmann::json command = service.links.Queue(LinkId(call), request, Now());
  response.status = 202;
  response.set_content(nlohmann::json{{"command", command}}.dump(), kJson);
}

}  // namespace

void PutLink(Service& service, const Call& call, httplib::Response& response) {
  const std::string& id = LinkId(call);
  LinkReport report = ParseLinkReport(BodyOf(call));
  const LinkBoard::Taken taken = service.links.Put(id, report, Now());
  Publish(service, id, report, taken.new_decisions);
  response.set_content(nlohmann::json{{"commands", taken.commands}}.dump(), kJson);
}

void GetLinks(Service& service, const Call& /*call*/, httplib::Response& response) {
  response.set_content(nlohmann::json{{"links", service.links.List(Now())}}.dump(), kJson);
}

void GetLink(Service& service, const Call& call, httplib::Response& response) {
  response.set_content(service.links.Find(call.Id("link"), Now()).dump(), kJson);
}

void PostLinkMission(Service& service, const Call& call, httplib::Response& response) {
  const CommandRequest request = ParseMissionRequest(BodyOf(call));
  RequireLandable(service, request.site_id);
  Queue(service, call, request, response);
}

void PostEngineFailure(Service& service, const Call& call, httplib::Response& response) {
  Queue(service, call, ParseCommandRequest(BodyOf(call), "engine_failure"), response);
}

void PostRelease(Service& service, const Call& call, httplib::Response& response) {
  Queue(service, call, ParseCommandRequest(BodyOf(call), "release"), response);
}

}  // namespace freelsd
