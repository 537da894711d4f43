#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include "api/api.h"
#include "api/stored/stored.h"
#include "server/handlers/handlers.h"
#include "server/handlers/lookups.h"
#include "server/http/http.h"
#include "server/intake/intake.h"
#include "server/jobs/jobs.h"

namespace freelsd {
namespace {

// Rows and changes that are committed together.
struct Admission {
  std::vector<FrameRow> frames;
  nlohmann::json verdicts = nlohmann::json::array();
  std::string rig_json;
  // Datum of the flight's altitudes, including these frames.
  std::optional<std::string> altitude_datum;
  std::vector<std::string> warnings;
  int64_t num_rejected = 0;
};

// Options from the query.
struct BatchOptions {
  bool is_dry_run = false;
  // Poses may name images that arrive in another request, or never.
  bool may_have_extra_poses = false;
  BatchAngles angles = BatchAngles::kChecked;
};

BatchAngles AnglesOf(const Call& call) {
  const std::string text = call.Query("angles").value_or("checked");
  if (text == "checked") return BatchAngles::kChecked;
  if (text == "given") return BatchAngles::kGiven;
  if (text == "none") return BatchAngles::kNone;
  const std::string detail = "angles: must be checked, given or none";
  throw ApiError("InvalidQuery", detail, {{"angles", detail}});
}

// The first poses whose image is neither in the request nor in the flight.
std::vector<FieldError> UnknownImages(const Service& service,
                                      const std::string& flight_id,
                                      const BatchUpload& upload) {
  std::set<std::string> known;
  for (const BatchImage& entry : upload.images()) known.insert(entry.id);
  std::vector<FieldError> errors;
  const auto& poses = upload.poses().poses;
  for (size_t i = 0; i < poses.size() && errors.size() < kLimits.answer.max_num_listed_errors;
       ++i) {
    const std::string& id = poses[i].first;
    if (known.contains(id) || service.storage.frames.Find(flight_id, id)) continue;
    errors.push_back({"/poses/" + std::to_string(i) + "/image", "there is no image " + id});
  }
  return errors;
}

void RefuseUnknownImages(const Service& service,
                         const std::string& flight_id,
                         const BatchUpload& upload) {
  const std::vector<FieldError> errors = UnknownImages(service, flight_id, upload);
  if (errors.empty()) return;
  throw ApiError("UnknownImages",
                 "poses name images that are neither in this request nor in the flight",
                 errors);
}

// Sorted by time if every image that can become a frame has a timestamp, else in the given order.
std::vector<BatchPhoto> InOrderOfFlight(const Intake& intake,
                                        const std::string& flight_id,
                                        const BatchUpload& upload) {
  std::map<std::string, FrameMeta> poses;
  for (const auto& [id, meta] : upload.poses().poses) poses[id] = meta;
  std::vector<BatchPhoto> photos;
  bool has_all_times = true;
  for (const BatchImage& entry : upload.images()) {
    BatchPhoto photo{entry, poses[entry.id], {}, {}};
    if (entry.image) {
      photo.tags = entry.image->tags.meta;
      photo.meta = KnownMeta(intake, flight_id, photo.given, photo.tags);
    }
    if (photo.meta.position) has_all_times &= photo.meta.timestamp_us.has_value();
    photos.push_back(std::move(photo));
  }
  if (has_all_times) {
    std::stable_sort(photos.begin(), photos.end(), [](const BatchPhoto& a, const BatchPhoto& b) {
      return a.meta.timestamp_us.value_or(0) < b.meta.timestamp_us.value_or(0);
    });
  }
  return photos;
}

// Throws ApiError if the image cannot become a frame; false if it is already stored as one.
bool AdmitOne(const Intake& intake,
              const std::string& flight_id,
              const BatchPhoto& photo,
              RigResolver& resolver,
              std::vector<FrameRow>& frames) {
  const BatchImage& entry = photo.image;
  if (!entry.reason.empty()) throw ApiError(entry.code, entry.reason);
  FrameRow frame = NewFrameRow(flight_id, entry.id, entry.image->sha256, {photo.given, photo.tags});
  frame.is_from_batch = true;
  if (SameFrame(intake, frame)) return false;
  resolver.Admit(*entry.image, photo.meta);
  frames.push_back(std::move(frame));
  return true;
}

void AddTo(std::vector<std::string>& warnings, const std::vector<std::string>& more) {
  warnings.insert(warnings.end(), more.begin(), more.end());
}

// What the flight's request, an earlier frame or a file beside the images determines.
PhotoRules RulesFor(const FlightRow& flight, const BatchUpload& upload, BatchAngles angles) {
  const bool has_camera = CameraOf(flight).has_value() || upload.poses().camera.has_value();
  const FlightRequest request = ParseStoredFlightRequest(flight.request_json);
  return {angles, has_camera, request.body_from_camera.has_value()};
}

Admission Admit(const Intake& intake,
                const FlightRow& flight,
                const BatchUpload& upload,
                BatchAngles angles) {
  const int64_t arrived_at_us = ArrivalNowUs();
  Admission admission;
  const PoseFile& poses = upload.poses();
  RigResolver resolver(flight, poses.camera);
  const bool has_datum = ParseStoredFlightRequest(flight.request_json).altitude_datum.has_value();
  admission.altitude_datum = ToldDatumOf(flight);
  admission.warnings = poses.warnings;
  if (poses.camera && ParseStoredFlightRequest(flight.request_json).camera) {
    admission.warnings.emplace_back(
        "the flight has a camera: the camera file beside the images is ignored");
  }
  std::vector<CaptureTime> times;
  const ComparedPhotos compared =
      ComparePhotos(InOrderOfFlight(intake, flight.id, upload), RulesFor(flight, upload, angles));
  AddTo(admission.warnings, compared.warnings);
  for (const BatchPhoto& photo : compared.photos) {
    nlohmann::json verdict{{"id", photo.image.id}, {"verdict", "accepted"}};
    try {
      if (!AdmitOne(intake, flight.id, photo, resolver, admission.frames)) {
        verdict["detail"] = "already stored";
      } else if (!has_datum) {
        admission.altitude_datum = CommonDatum(admission.altitude_datum, photo.meta);
      }
      AddTo(admission.warnings, resolver.RelevantWarnings(*photo.image.image));
      times.push_back(
          CaptureTimeOf(photo.meta.timestamp_us, photo.meta.time_source, {arrived_at_us}));
    } catch (const ApiError& error) {
      verdict["verdict"] = "rejected";
      verdict["code"] = error.code();
      verdict["detail"] = error.what();
      ++admission.num_rejected;
    }
    admission.verdicts.push_back(std::move(verdict));
  }
  AddTo(admission.warnings, TimeWarnings(times, arrived_at_us));
  admission.rig_json = resolver.RigJson();
  // Removes duplicates, because many images cause the same warning.
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

// Ids of images that no pose names, in the order of the upload.
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
  nlohmann::json detail = DetailJson(admission, upload);
  // No frame will ever end such a job. It therefore ends now, with the reason.
  if (!admission.verdicts.empty() && detail["num_accepted"] == 0) {
    job.state = JobState::kDone;
    job.progress_ratio = 1.0;
    job.stage.clear();
    detail["message"] = "no photograph was accepted; the first reason: " +
                        admission.verdicts.front().at("detail").get<std::string>();
  }
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

// The camera that a batch without dry_run would use; null if it is unknown.
nlohmann::json CameraToBeTaken(const FlightRow& flight,
                               const Admission& admission,
                               const PoseFile& poses) {
  if (!admission.rig_json.empty()) {
    return CameraJson(ParseStoredFlightRig(admission.rig_json).rig.camera);
  }
  const std::optional<Camera> given = ParseStoredFlightRequest(flight.request_json).camera;
  if (given) return CameraJson(*given);
  return poses.camera ? CameraJson(*poses.camera) : nlohmann::json();
}

// Reports all findings that the same request without dry_run would have. Stores nothing.
nlohmann::json DryRun(const Service& service,
                      const FlightRow& flight,
                      BatchUpload& upload,
                      const BatchOptions& options) {
  nlohmann::json problems = nlohmann::json::array();
  try {
    upload.ParsePoses(ParseStoredFlightRequest(flight.request_json).origin);
    if (!options.may_have_extra_poses) RefuseUnknownImages(service, flight.id, upload);
  } catch (const ApiError& error) {
    AppendProblem(error, problems);
  }
  const Admission admission = Admit(service.intake, flight, upload, options.angles);
  nlohmann::json answer = DetailJson(admission, upload);
  std::vector<std::string> unposed = ImagesWithoutPose(upload);
  unposed.resize(std::min(unposed.size(), kLimits.answer.max_num_listed_errors));
  answer["dry_run"] = true;
  answer["would_be_refused"] = !problems.empty();
  answer["problems"] = problems;
  answer["images_without_pose"] = unposed;
  answer["altitude_datum"] = admission.altitude_datum.value_or("unknown");
  answer["camera"] = CameraToBeTaken(flight, admission, upload.poses());
  return answer;
}

JobRow StoreBatch(Service& service,
                  const Call& call,
                  const BatchUpload& upload,
                  BatchAngles angles) {
  const FlightRow stored = ExistingFlight(service, call);
  const Admission admission = Admit(service.intake, stored, upload, angles);
  JobRow job = NewBatchJob(stored.id, admission, upload);
  service.storage.frames.Insert(stored.id, admission.frames, job, [&](FlightRow& flight) {
    // Since the upload began.
    RefuseWhenRetired(flight);
    // A stored rig is kept, because another request may have added a datum to it since it was read.
    if (flight.rig_json.empty()) flight.rig_json = admission.rig_json;
    flight.num_rejected_frames += admission.num_rejected;
    flight.warnings_json = AddWarnings(flight.warnings_json, "images", admission.warnings);
  });
  return job;
}

// Looks at the frames again if another server has stored one of them meanwhile.
JobRow StoreBatchBesideOthers(Service& service,
                              const Call& call,
                              const BatchUpload& upload,
                              BatchAngles angles) {
  try {
    return StoreBatch(service, call, upload, angles);
  } catch (const StorageError& error) {
    if (error.fault != StorageFault::kConflict) throw;
    return StoreBatch(service, call, upload, angles);
  }
}

}  // namespace

void PostBatch(Service& service, const Call& call, httplib::Response& response) {
  const FlightRow flight_row = ExistingFlight(service, call);
  RefuseWhenRetired(flight_row);
  const std::string flight_id = flight_row.id;
  const Receiving receiving(service.intake, flight_id);
  const BatchOptions options{
      call.QueryFlag("dry_run"), call.QueryFlag("extra_poses"), AnglesOf(call)};
  BatchUpload upload(service.intake);
  upload.Read(call);
  if (options.is_dry_run) {
    const nlohmann::json answer = DryRun(service, ExistingFlight(service, call), upload, options);
    response.set_content(answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace),
                         "application/json");
    return;
  }
  upload.ParsePoses(ParseStoredFlightRequest(ExistingFlight(service, call).request_json).origin);
  if (!options.may_have_extra_poses) RefuseUnknownImages(service, flight_id, upload);
  const std::lock_guard lock(service.intake.intake_mutex);
  const JobRow job = StoreBatchBesideOthers(service, call, upload, options.angles);
  service.events.Publish("job", flight_id, JobJson(service, job).dump());
  service.intake.wake_worker();
  service.intake.on_new_pose(flight_id);
  AnswerJob(service, job, response);
}

}  // namespace freelsd
