// What an organisation may use of a database that it shares with others.
#pragma once

#include <cstdint>
#include <optional>

namespace freelsd {

// Nothing: no limit.
struct Quotas {
  // Photographs, and pictures of maps.
  std::optional<int64_t> max_num_image_bytes;
  // On average; as many may come at once after a minute of silence.
  std::optional<double> max_frames_per_minute;
  std::optional<int64_t> max_num_unfinished_jobs;
};

// What a request would add.
struct QuotaDemand {
  int64_t num_image_bytes = 0;
  int64_t num_frames = 0;
  int64_t num_jobs = 0;
};

enum class Quota { kImageBytes, kFrames, kJobs };

struct QuotaRefusal {
  Quota quota = Quota::kFrames;
  double limit = 0.0;
  // What there would be.
  double observed = 0.0;
  // When the frames may come.
  double wait_s = 0.0;
};

class QuotaStore {
 public:
  virtual ~QuotaStore() = default;
  QuotaStore(const QuotaStore&) = delete;
  QuotaStore& operator=(const QuotaStore&) = delete;

  // Counts the frames if nothing is refused. Bytes and jobs count when they are stored, so requests
  // that are answered at the same time may together exceed a quota by what they add. More frames
  // than come in a minute are taken at once, if none came for a minute; later ones wait the longer.
  virtual std::optional<QuotaRefusal> Admit(const Quotas& quotas, const QuotaDemand& demand) = 0;

 protected:
  QuotaStore() = default;
};

}  // namespace freelsd
