#include <memory>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

// Period of a comment line. It keeps proxies from closing the connection.
constexpr std::chrono::milliseconds kHeartbeatPeriod{2000};
constexpr std::chrono::milliseconds kRetryAfter{2000};

// A listening client and its position in the log. The destructor frees its slot.
struct EventClient {
  Service& service;
  std::string flight_id;
  int64_t number = 0;

  explicit EventClient(Service& all) : service(all) {}
  ~EventClient() { service.event_clients.release(); }
  EventClient(const EventClient&) = delete;
  EventClient& operator=(const EventClient&) = delete;
};

std::string TextOf(const EventLog& log, const Event& event) {
  return "id: " + log.IdOf(event.number) + "\nevent: " + event.type + "\ndata: " + event.data +
         "\n\n";
}

// The event "resync": events were dropped, so the client must fetch the whole state.
std::string ResyncText(const EventLog& log, int64_t number) {
  return "id: " + log.IdOf(number) + "\nevent: resync\ndata: {}\n\n";
}

// The events since the last call.
LiveText NewsOf(EventClient& client) {
  const EventLog& log = client.service.events;
  const EventLog::Batch batch =
      log.After(client.number, client.flight_id, kLimits.events.max_unsent_bytes);
  client.number = batch.last_number;
  LiveText news;
  news.is_over = batch.is_over;
  if (batch.has_gap) news.text = ResyncText(log, batch.last_number);
  for (const Event& event : batch.events) news.text += TextOf(log, event);
  return news;
}

}  // namespace

void GetEvents(Service& service, const Call& call, httplib::Response& response) {
  const std::string flight_id = call.Query("flight").value_or("");
  if (!flight_id.empty() && !service.storage.flights.Find(flight_id)) {
    throw ApiError("NoSuchFlight", "there is no such flight", {{"flight", "does not exist"}});
  }
  if (call.request.method == "HEAD") return response.set_content("", "text/event-stream");
  if (!service.event_clients.try_acquire()) {
    throw ApiError("Unavailable", "too many clients listen to events");
  }
  const auto client = std::make_shared<EventClient>(service);
  client->flight_id = flight_id;
  client->number = service.events.LastNumber();
  std::string begin = "retry: " + std::to_string(kRetryAfter.count()) + "\n\n";
  const std::string last_id = call.request.get_header_value("Last-Event-ID");
  if (!last_id.empty()) {
    const std::optional<int64_t> number = service.events.NumberOf(last_id);
    client->number = number.value_or(client->number);
    if (!number) begin += ResyncText(service.events, client->number);
  }
  response.set_header("X-Accel-Buffering", "no");
  AnswerLive(response,
             "text/event-stream",
             begin,
             {[client] { return NewsOf(*client); }, ": heartbeat\n\n", kHeartbeatPeriod});
}

}  // namespace freelsd
