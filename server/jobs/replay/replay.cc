#include "server/jobs/replay/replay.h"

#include <algorithm>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "server/intake/intake.h"
#include "server/jobs/evaluation.h"
#include "server/jobs/job_json.h"

namespace freelsd {
namespace {

// Share of the replay after which the regions are known.
constexpr double kRegionsDone = 0.4;

// How far the flight's last finish went.
struct FinishedAt {
  // Of the last frame before its flush, and of the last frame that it has evaluated.
  int64_t flushed_through = 0;
  int64_t through_sequence = 0;
};

FinishedAt LastFinish(const Storage& storage, const std::string& flight_id) {
  FinishedAt last;
  for (const JobRow& job : storage.jobs.ListOf(flight_id)) {
    if (job.kind != "finish" || job.state != JobState::kDone) continue;
    const auto detail = nlohmann::json::parse(job.detail_json);
    const auto through = detail.find("through_sequence");
    if (through == detail.end() || *through <= last.through_sequence) continue;
    last = {LastSequenceOf(job, storage), *through};
  }
  if (last.through_sequence == 0) throw std::runtime_error("no finish of this flight is done");
  return last;
}

void GiveFrame(Service& service, const FrameRow& row, FlightSession& session) {
  const PosedFrame frame(row);
  if (!frame.meta) return session.Skip(row.sequence);
  const cv::Mat image = StoredImage(service.intake, row);
  if (image.empty()) throw std::runtime_error("the photograph " + row.id + " is gone");
  session.GiveWinds(service.storage, service.config, *frame.meta);
  session.Give(row, *frame.meta, image);
}

void GiveFrames(Service& service,
                const std::string& flight_id,
                const FinishedAt& finished,
                FlightSession& session,
                const Progress& progress) {
  for (const FrameRow& row : service.storage.frames.List(flight_id)) {
    if (row.sequence > finished.through_sequence) break;
    const double done =
        static_cast<double>(row.sequence) / static_cast<double>(finished.through_sequence);
    if (!progress(kRegionsDone * done, "frontend")) throw std::runtime_error("cancelled");
    GiveFrame(service, row, session);
    if (row.sequence == finished.flushed_through) session.Flush(row.sequence);
  }
}

std::string DigestOf(const SiteRow& site) {
  const auto properties = nlohmann::json::parse(site.feature_json).at("properties");
  return properties.value("evidence_digest", std::string());
}

nlohmann::json TextOrNull(const std::string& text) {
  return text.empty() ? nlohmann::json() : nlohmann::json(text);
}

}  // namespace

nlohmann::json ReplayFlight(Service& service,
                            const std::string& flight_id,
                            const GroundModels& ground_models,
                            const Progress& progress) {
  const auto flight = service.storage.flights.Find(flight_id);
  if (!flight) throw std::runtime_error("the flight was deleted");
  const FinishedAt finished = LastFinish(service.storage, flight_id);
  FlightSession session(*flight, ground_models);
  GiveFrames(service, flight_id, finished, session, progress);
  std::map<std::string, std::string> replayed =
      EvidenceDigests(service, flight_id, session, [&](double ratio, const std::string& stage) {
        return progress(kRegionsDone + (1.0 - kRegionsDone) * ratio, stage);
      });
  nlohmann::json answer{{"sites", nlohmann::json::array()}, {"num_equal", 0}};
  int num_equal = 0;
  const auto add = [&](const std::string& id, const std::string& stored, const std::string& now) {
    const bool is_equal = !stored.empty() && stored == now;
    num_equal += is_equal;
    answer["sites"].push_back({{"site_id", id},
                               {"stored", TextOrNull(stored)},
                               {"replayed", TextOrNull(now)},
                               {"is_equal", is_equal}});
  };
  for (const SiteRow& site : service.storage.sites.List(flight_id, std::nullopt)) {
    add(site.id, DigestOf(site), replayed[site.id]);
    replayed.erase(site.id);
  }
  for (const auto& [id, digest] : replayed) add(id, "", digest);
  answer["num_equal"] = num_equal;
  return answer;
}

}  // namespace freelsd
