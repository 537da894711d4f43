// What each organisation has of this server. Nothing in memory is common to two of them.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/jobs/service.h"

namespace freelsd {

// Owns what its service refers to.
struct Organisation {
  Organisation(const Config& config,
               const std::string& name,
               std::unique_ptr<Storage> opened,
               const BaseMap& base_map,
               size_t num_organisations,
               LongQueues& long_queues);

  std::unique_ptr<Storage> storage;
  EventLog events;
  MapCache maps;
  Intake intake;
  Alternates alternates;
  Service service;
};

// Thread-safe.
class Organisations {
 public:
  using Call = std::function<void(const std::string& name, Organisation& organisation)>;

  // `storage`: of the default organisation.
  Organisations(const Config& config, std::unique_ptr<Storage> storage, const BaseMap& base_map);
  ~Organisations();
  Organisations(const Organisations&) = delete;
  Organisations& operator=(const Organisations&) = delete;

  // `call` gets each organisation, those of today and the later ones, once and before its service
  // is used. To be set before the first use.
  void CallWithEach(const Call& call);
  // Those that are open now.
  void ForEach(const Call& call);

  // Of tokens without an organisation; it has what is the process's, too: page, tokens, claims.
  Service& Default() { return default_.service; }
  const Service& Default() const { return default_.service; }
  // Opens the organisation if it is not open yet.
  Service& Of(const std::string& name);
  // Nothing if it is not open.
  Organisation* Find(const std::string& name);

 private:
  Organisation& Opened(const std::string& name);

  const Config& config_;
  const BaseMap& base_map_;
  // Memory is shared out among as many.
  size_t num_organisations_;
  LongQueues long_queues_;
  // Guards call_ and others_; the entries stay.
  std::mutex mutex_;
  Call call_ = [](const std::string&, Organisation&) {};
  Organisation default_;
  std::map<std::string, std::unique_ptr<Organisation>> others_;
};

}  // namespace freelsd
