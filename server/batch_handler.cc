#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "server/batch.h"
#include "server/flight_lookup.h"
#include "server/frame_resolution.h"
#include "server/handlers.h"
#include "server/job_json.h"
#include "server/stamps.h"
#include "server/warnings.h"

namespace freelsd {
namespace {

// Unknown images listed in one answer.
constexpr size_t kMaxNumListedErrors = 20;

// An image with what its pose file says, and with all that is known of it, in the order of flight.
struct Candidate {
  const BatchImage* entry = nullptr;
  FrameMeta given;
  FrameMeta meta;
};

// What is to be committed together.
struct Admission {
  std::vector<FrameRow> frames;
  nlohmann::json verdicts = nlohmann::json::array();
  std::string rig_json;
  std::vector<std::string> warnings;
  int64_t num_rejected = 0;
};

// What the query says.
struct BatchOptions {
  bool is_dry_run = false;
  // Poses may be of images that come in another request, or never.
  bool may_have_extra_poses = false;
};

// Poses that no image is there for, the first of them.
std::vector<FieldError> UnknownImages(const Service& service,
                                      const std::string& flight_id,
                                      const BatchUpload& upload) {
  std::set<std::string> known;
  for (const BatchImage& entry : upload.images()) known.insert(entry.id);
  std::vector<FieldError> errors;
  const auto& poses = upload.poses().poses;
  for (size_t i = 0; i < poses.size() && errors.size() < kMaxNumListedErrors; ++i) {
    const std::string& id = poses[i].first;
    if (known.contains(id) || service.storage.FindFrame(flight_id, id)) continue;
    errors.push_back({"/poses/" + std::to_string(i) + "/image", "there is no image " + id});
  }
  return errors;
}

void RefuseUnknownImages(const Service& service,
                         const std::string& flight_id,
                         const BatchUpload& upload) {
  const std::vector<FieldError> errors = UnknownImages(service, flight_id, upload);
  if (errors.empty()) return;
  throw ApiError(
      "UnknownImages", "poses name images that are neither here nor in the flight", errors);
}

// By time where every image that can become a frame has one, else as given.
std::vector<Candidate> InOrderOfFlight(const Service& service,
                                       const std::string& flight_id,
                                       const BatchUpload& upload) {
  std::map<std::string, FrameMeta> poses;
  for (const auto& [id, meta] : upload.poses().poses) poses[id] = meta;
  std::vector<Candidate> candidates;
  bool has_all_times = true;
  for (const BatchImage& entry : upload.images()) {
    Candidate candidate{&entry, poses[entry.id], {}};
    if (entry.image) {
      candidate.meta = KnownMeta(service, flight_id, candidate.given, entry.image->tags.meta);
    }
    if (candidate.meta.position) has_all_times &= candidate.meta.timestamp_us.has_value();
    candidates.push_back(std::move(candidate));
  }
  if (has_all_times) {
    std::stable_sort(
        candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
          return a.meta.timestamp_us.value_or(0) < b.meta.timestamp_us.value_or(0);
        });
  }
  return candidates;
}

// Throws ApiError where the image cannot be a frame; false where it is one already.
bool AdmitOne(const Service& service,
              const std::string& flight_id,
              const Candidate& candidate,
              RigResolver& resolver,
              std::vector<FrameRow>& frames) {
  const BatchImage& entry = *candidate.entry;
  if (!entry.image) throw ApiError(entry.code, entry.reason);
  FrameRow frame = NewFrameRow(flight_id, entry.id, *entry.image, candidate.given);
  frame.is_from_batch = true;
  if (const auto stored = service.storage.FindFrame(flight_id, entry.id)) {
    if (stored->sha256 == frame.sha256 && stored->meta_json == frame.meta_json) return false;
    throw ApiError("FrameConflict", "the frame is stored with another image or meta");
  }
  resolver.Admit(*entry.image, candidate.meta);
  frames.push_back(std::move(frame));
  return true;
}

Admission Admit(const Service& service, const FlightRow& flight, const BatchUpload& upload) {
  Admission admission;
  const PoseFile& poses = upload.poses();
  RigResolver resolver(flight, poses.camera);
  admission.warnings = poses.warnings;
  if (poses.camera && ParseFlightRequest(flight.request_json).camera) {
    admission.warnings.emplace_back(
        "the flight has a camera: the one beside the images is not used");
  }
  for (const Candidate& candidate : InOrderOfFlight(service, flight.id, upload)) {
    nlohmann::json verdict{{"id", candidate.entry->id}, {"verdict", "accepted"}};
    try {
      if (!AdmitOne(service, flight.id, candidate, resolver, admission.frames)) {
        verdict["detail"] = "was stored already";
      }
      const std::vector<std::string> warnings = resolver.RelevantWarnings(*candidate.entry->image);
      admission.warnings.insert(admission.warnings.end(), warnings.begin(), warnings.end());
    } catch (const ApiError& error) {
      verdict["verdict"] = "rejected";
      verdict["code"] = error.code();
      verdict["detail"] = error.what();
      ++admission.num_rejected;
    }
    admission.verdicts.push_back(std::move(verdict));
  }
  admission.rig_json = resolver.RigJson();
  // Each once: many images warn of the same.
  std::sort(admission.warnings.begin(), admission.warnings.end());
  admission.warnings.erase(std::unique(admission.warnings.begin(), admission.warnings.end()),
                           admission.warnings.end());
  return admission;
}

nlohmann::json FormatsJson(const PoseFile& poses) {
  nlohmann::json formats = nlohmann::json::array();
  for (const PoseFile::Format& format : poses.formats) {
    formats.push_back({{"format", format.name}, {"file", format.path}, {"why", format.why}});
  }
  return formats;
}

// Those that no pose names, in their order.
std::vector<std::string> ImagesWithoutPose(const BatchUpload& upload) {
  std::set<std::string> posed;
  for (const auto& [id, meta] : upload.poses().poses) posed.insert(id);
  std::vector<std::string> unposed;
  for (const BatchImage& entry : upload.images()) {
    if (!posed.contains(entry.id)) unposed.push_back(entry.id);
  }
  return unposed;
}

nlohmann::json DetailJson(const Admission& admission, const BatchUpload& upload) {
  const int64_t num_images = static_cast<int64_t>(admission.verdicts.size());
  return {{"images", admission.verdicts},
          {"num_accepted", num_images - admission.num_rejected},
          {"num_rejected", admission.num_rejected},
          {"num_poses", upload.poses().poses.size()},
          {"num_images_without_pose", ImagesWithoutPose(upload).size()},
          {"formats", FormatsJson(upload.poses())},
          {"warnings", admission.warnings}};
}

JobRow NewBatchJob(const std::string& flight_id,
                   const Admission& admission,
                   const BatchUpload& upload) {
  JobRow job;
  job.id = NewId("j");
  job.kind = "batch";
  job.flight_id = flight_id;
  job.stage = "frontend";
  job.created_at_us = NowUs();
  const nlohmann::json detail = DetailJson(admission, upload);
  job.detail_json = detail.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return job;
}

void AppendProblem(const ApiError& error, nlohmann::json& problems) {
  nlohmann::json problem{{"code", error.code()}, {"detail", error.what()}};
  problem["errors"] = nlohmann::json::array();
  for (const FieldError& field : error.errors()) {
    problem["errors"].push_back({{"pointer", field.pointer}, {"detail", field.detail}});
  }
  problems.push_back(problem);
}

// The camera that the images would be taken with; null where nothing says.
nlohmann::json CameraToBeTaken(const FlightRow& flight,
                               const Admission& admission,
                               const PoseFile& poses) {
  if (!admission.rig_json.empty()) {
    return CameraJson(ParseStoredFlightRig(admission.rig_json).rig.camera);
  }
  const std::optional<Camera> given = ParseFlightRequest(flight.request_json).camera;
  if (given) return CameraJson(*given);
  return poses.camera ? CameraJson(*poses.camera) : nlohmann::json();
}

// What the same request without dry_run would meet, all of it at once. Stores nothing.
nlohmann::json DryRun(const Service& service,
                      const FlightRow& flight,
                      BatchUpload& upload,
                      const BatchOptions& options) {
  nlohmann::json problems = nlohmann::json::array();
  try {
    upload.ParsePoses(ParseFlightRequest(flight.request_json).origin);
    if (!options.may_have_extra_poses) RefuseUnknownImages(service, flight.id, upload);
  } catch (const ApiError& error) {
    AppendProblem(error, problems);
  }
  const Admission admission = Admit(service, flight, upload);
  nlohmann::json answer = DetailJson(admission, upload);
  std::vector<std::string> unposed = ImagesWithoutPose(upload);
  unposed.resize(std::min(unposed.size(), kMaxNumListedErrors));
  answer["dry_run"] = true;
  answer["would_be_refused"] = !problems.empty();
  answer["problems"] = problems;
  answer["images_without_pose"] = unposed;
  answer["altitude_datum"] = ParseFlightRequest(flight.request_json).altitude_datum;
  answer["camera"] = CameraToBeTaken(flight, admission, upload.poses());
  return answer;
}

}  // namespace

void PostBatch(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight_row = ExistingFlight(service, call);
  RefuseWhenRetired(flight_row);
  const std::string flight_id = flight_row.id;
  const Receiving receiving(service, flight_id);
  const BatchOptions options{call.QueryFlag("dry_run"), call.QueryFlag("extra_poses")};
  BatchUpload upload(service);
  upload.Read(call);
  if (options.is_dry_run) {
    const nlohmann::json answer = DryRun(service, ExistingFlight(service, call), upload, options);
    response.set_content(answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                         "application/json");
    return;
  }
  upload.ParsePoses(ParseFlightRequest(ExistingFlight(service, call).request_json).origin);
  if (!options.may_have_extra_poses) RefuseUnknownImages(service, flight_id, upload);
  const std::lock_guard lock(service.intake_mutex);
  const Admission admission = Admit(service, ExistingFlight(service, call), upload);
  const JobRow job = NewBatchJob(flight_id, admission, upload);
  service.storage.InsertFrames(flight_id, admission.frames, job, [&](FlightRow& flight) {
    flight.rig_json = admission.rig_json;
    flight.num_rejected_frames += admission.num_rejected;
    flight.warnings_json = AddWarnings(flight.warnings_json, "images", admission.warnings);
  });
  service.events.Publish("job", flight_id, JobJson(job).dump());
  service.wake_worker();
  AnswerJob(job, response);
}

}  // namespace freelsd
