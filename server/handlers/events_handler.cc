#include <memory>

#include "api/api.h"
#include "server/handlers/handlers.h"
#include "server/http/http.h"

namespace freelsd {
namespace {

// Period of a comment line. It keeps proxies from closing the connection, and detects a client that
// left: its slot is free once a line cannot be written.
constexpr std::chrono::seconds kHeartbeatPeriod{2};
constexpr std::chrono::milliseconds kRetryAfter{2000};

// A listening client and its position in the log. The destructor frees its slot.
struct EventClient {
  Service& service;
  std::string flight_id;
  int64_t number = 0;
  bool has_missed = false;
  bool is_greeted = false;

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

std::string Greeting(EventClient& client) {
  client.is_greeted = true;
  const EventLog& log = client.service.events;
  std::string text = "retry: " + std::to_string(kRetryAfter.count()) + "\n\n";
  if (client.has_missed) text += ResyncText(log, client.number);
  return text;
}

// Sends new events, or a heartbeat. False at the end.
bool Send(EventClient& client, httplib::DataSink& sink) {
  const EventLog& log = client.service.events;
  std::string text;
  bool is_over = false;
  if (!client.is_greeted) {
    text = Greeting(client);
  } else {
    const auto deadline = std::chrono::steady_clock::now() + kHeartbeatPeriod;
    const EventLog::Batch batch = log.WaitAfter(client.number, client.flight_id, deadline);
    client.number = batch.last_number;
    is_over = batch.is_over;
    if (batch.has_gap) {
      text = ResyncText(log, batch.last_number);
    } else {
      for (const Event& event : batch.events) text += TextOf(log, event);
    }
    if (text.empty()) text = ": heartbeat\n\n";
  }
  if (!sink.write(text.data(), text.size()) || !FlushAnswer()) return false;
  if (is_over) sink.done();
  return true;
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
  const std::string last_id = call.request.get_header_value("Last-Event-ID");
  if (!last_id.empty()) {
    const std::optional<int64_t> number = service.events.NumberOf(last_id);
    client->has_missed = !number.has_value();
    client->number = number.value_or(client->number);
  }
  response.set_header("X-Accel-Buffering", "no");
  response.set_chunked_content_provider(
      "text/event-stream",
      [client](size_t, httplib::DataSink& sink) { return Send(*client, sink); });
}

}  // namespace freelsd
