// Flights and the regions that the engine finds in them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace freelsd {

struct FlightRow {
  std::string id;
  std::string name;
  std::string request_json;
  // JSON text of camera, body_from_camera, origin and the datum of the frames. Empty until a frame
  // determines them.
  std::string rig_json;
  std::string warnings_json = "[]";
  std::string stages_json = "{}";
  int64_t created_at_us = 0;
  // Frames that intake or processing refused.
  int64_t num_rejected_frames = 0;
  bool has_failed = false;
  // Altitude of the ground below the first frame, in the flight's datum; empty until estimated.
  std::optional<double> ground_altitude_m;
  // True if the flight's images were removed to free disk space. Such a flight accepts no further
  // frames; its regions and sites stay.
  bool has_retired_images = false;
};

// A flight with the numbers that lists show.
struct FlightSummary {
  FlightRow flight;
  // Order of creation.
  int64_t number = 0;
  int64_t num_frames = 0;
  int64_t num_queued_frames = 0;
  int64_t num_regions = 0;
  int64_t num_sites = 0;
  bool has_unfinished_job = false;
};

struct FlightPage {
  std::vector<FlightSummary> flights;
  // True if more flights follow after the last one of this page.
  bool has_more = false;
};

using FlightChange = std::function<void(FlightRow& flight)>;

struct RegionRow {
  int64_t id = 0;
  std::string feature_json;
  std::string history_json;
};

// Invariant: a flight's frames, jobs, telemetry and regions exist only while the flight does.
class FlightStore {
 public:
  virtual ~FlightStore() = default;
  FlightStore(const FlightStore&) = delete;
  FlightStore& operator=(const FlightStore&) = delete;

  virtual void Insert(const FlightRow& flight) = 0;
  // Reads, changes and writes the row in one transaction. Changes to id, request_json and
  // created_at_us are ignored. False if there is no such flight.
  virtual bool Change(const std::string& flight_id, const FlightChange& change) = 0;
  virtual std::optional<FlightRow> Find(const std::string& flight_id) const = 0;
  virtual std::optional<FlightSummary> FindSummary(const std::string& flight_id) const = 0;
  virtual std::vector<FlightRow> List() const = 0;  // newest first
  // Newest first. The page begins with the flight before `before_number`, or with the newest
  // flight. The duration depends on `limit`, not on the number of flights.
  virtual FlightPage ListPage(size_t limit, std::optional<int64_t> before_number) const = 0;
  virtual int64_t Count() const = 0;
  virtual std::vector<std::string> ListWithQueuedFrames() const = 0;  // ids, oldest first
  // Deletes the flight, and the images that neither another flight nor a map needs. Its sites and
  // maps stay (see EvaluationRows::deleted_flight). False if there is no such flight.
  virtual bool Delete(const std::string& flight_id) = 0;
  // Removes the images that no other flight needs, and sets has_retired_images. False, and nothing
  // is changed, if a frame or a job waits for the engine, or if other servers share the database
  // and the flight or a frame of it arrived in the last ten minutes: one of them may be receiving
  // the next.
  virtual bool RetireImages(const std::string& flight_id) = 0;

  // Replaces all regions of the flight in one commit. Order: best first.
  virtual void ReplaceRegions(const std::string& flight_id,
                              const std::vector<RegionRow>& regions) = 0;
  virtual std::vector<RegionRow> ListRegions(const std::string& flight_id) const = 0;
  virtual int64_t CountRegions(const std::string& flight_id) const = 0;

 protected:
  FlightStore() = default;
};

}  // namespace freelsd
