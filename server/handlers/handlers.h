// The handlers that the table in routes.cc refers to, grouped by the file that defines them. They
// throw ApiError and StorageError. Several threads may call them at the same time.
#pragma once

#include "server/http/http.h"
#include "server/jobs/jobs.h"

namespace freelsd {

// flight_handlers.cc
void PostFlight(Service& service, const Call& call, httplib::Response& response);
void GetFlights(Service& service, const Call& call, httplib::Response& response);
void GetFlight(Service& service, const Call& call, httplib::Response& response);
void PatchFlight(Service& service, const Call& call, httplib::Response& response);
void DeleteFlight(Service& service, const Call& call, httplib::Response& response);

// track_handler.cc
void GetTrack(Service& service, const Call& call, httplib::Response& response);

// frame_handlers.cc
void PutFrame(Service& service, const Call& call, httplib::Response& response);
void PostFrame(Service& service, const Call& call, httplib::Response& response);
void GetFrames(Service& service, const Call& call, httplib::Response& response);

// evidence/patch_handler.cc
void GetFramePatch(Service& service, const Call& call, httplib::Response& response);

// batch_handler.cc
void PostBatch(Service& service, const Call& call, httplib::Response& response);

// job_handlers.cc
void PostFinish(Service& service, const Call& call, httplib::Response& response);
void PostReplay(Service& service, const Call& call, httplib::Response& response);
void GetJobs(Service& service, const Call& call, httplib::Response& response);
void GetJob(Service& service, const Call& call, httplib::Response& response);
void DeleteJob(Service& service, const Call& call, httplib::Response& response);

// result_handlers.cc
void GetRegions(Service& service, const Call& call, httplib::Response& response);
void GetRegionHistory(Service& service, const Call& call, httplib::Response& response);
void GetFlightSites(Service& service, const Call& call, httplib::Response& response);
void GetSites(Service& service, const Call& call, httplib::Response& response);
void GetSite(Service& service, const Call& call, httplib::Response& response);
void DeleteSite(Service& service, const Call& call, httplib::Response& response);

// approach_handler.cc
void GetApproach(Service& service, const Call& call, httplib::Response& response);
void GetWhy(Service& service, const Call& call, httplib::Response& response);
void GetFlightWhy(Service& service, const Call& call, httplib::Response& response);
void GetFlightLanding(Service& service, const Call& call, httplib::Response& response);
void GetWindRose(Service& service, const Call& call, httplib::Response& response);

// export/flight_report_handler.cc
void GetFlightAs(Service& service, const Call& call, httplib::Response& response);

// export/export_handler.cc
void GetSiteAs(Service& service, const Call& call, httplib::Response& response);
void GetFlightSitesAs(Service& service, const Call& call, httplib::Response& response);
void GetLayerWorldFile(Service& service, const Call& call, httplib::Response& response);

// layer_handlers.cc
void GetLayers(Service& service, const Call& call, httplib::Response& response);
void GetLayerPicture(Service& service, const Call& call, httplib::Response& response);
void GetLayerGeoTiff(Service& service, const Call& call, httplib::Response& response);
void GetLayerLegend(Service& service, const Call& call, httplib::Response& response);

// map_handlers.cc
void GetFlightMap(Service& service, const Call& call, httplib::Response& response);
void GetMapTilePng(Service& service, const Call& call, httplib::Response& response);
void GetMapTileJpeg(Service& service, const Call& call, httplib::Response& response);
void GetMapGeoTiff(Service& service, const Call& call, httplib::Response& response);
void GetMapKmz(Service& service, const Call& call, httplib::Response& response);
void GetMapLegend(Service& service, const Call& call, httplib::Response& response);

// emergency_handlers.cc
void GetEmergency(Service& service, const Call& call, httplib::Response& response);
void PostEmergency(Service& service, const Call& call, httplib::Response& response);
void GetEmergencyExport(Service& service, const Call& call, httplib::Response& response);

// foresight/route_handler.cc
void PostRouteCheck(Service& service, const Call& call, httplib::Response& response);

// foresight/next_look_handler.cc
void GetNextLook(Service& service, const Call& call, httplib::Response& response);

// obstacle_handlers.cc
void PutObstacle(Service& service, const Call& call, httplib::Response& response);
void PostObstacles(Service& service, const Call& call, httplib::Response& response);
void GetObstacles(Service& service, const Call& call, httplib::Response& response);
void GetObstacle(Service& service, const Call& call, httplib::Response& response);
void DeleteObstacle(Service& service, const Call& call, httplib::Response& response);

// following/change_handlers.cc
void GetChanges(Service& service, const Call& call, httplib::Response& response);
void PostChanges(Service& service, const Call& call, httplib::Response& response);
void GetStoredMap(Service& service, const Call& call, httplib::Response& response);
void PutStoredMap(Service& service, const Call& call, httplib::Response& response);

// links/link_handlers.cc
void PutLink(Service& service, const Call& call, httplib::Response& response);
void GetLinks(Service& service, const Call& call, httplib::Response& response);
void GetLink(Service& service, const Call& call, httplib::Response& response);
void PostLinkMission(Service& service, const Call& call, httplib::Response& response);
void PostEngineFailure(Service& service, const Call& call, httplib::Response& response);
void PostRelease(Service& service, const Call& call, httplib::Response& response);

// reach_handler.cc
void GetReach(Service& service, const Call& call, httplib::Response& response);
void PostReach(Service& service, const Call& call, httplib::Response& response);

// base_map_handlers.cc
void GetBaseMap(Service& service, const Call& call, httplib::Response& response);
void GetBaseMapTile(Service& service, const Call& call, httplib::Response& response);

// alternates_handler.cc
void GetAlternates(Service& service, const Call& call, httplib::Response& response);

// telemetry_handler.cc
void PostTelemetry(Service& service, const Call& call, httplib::Response& response);

// stream_handler.cc
void PostStream(Service& service, const Call& call, httplib::Response& response);

// events_handler.cc
void GetEvents(Service& service, const Call& call, httplib::Response& response);

// service_handlers.cc
void GetHealth(Service& service, const Call& call, httplib::Response& response);
void GetReadiness(Service& service, const Call& call, httplib::Response& response);
void GetNotices(Service& service, const Call& call, httplib::Response& response);
void PostAcknowledgement(Service& service, const Call& call, httplib::Response& response);
void GetMetrics(Service& service, const Call& call, httplib::Response& response);
void GetInfo(Service& service, const Call& call, httplib::Response& response);
void GetOpenApi(Service& service, const Call& call, httplib::Response& response);

}  // namespace freelsd
