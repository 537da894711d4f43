#include "server/http/connections/poller.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace freelsd {
namespace {

constexpr size_t kMaxNumEvents = 256;

// Throws std::runtime_error if a call returned a negative result.
int Checked(const char* call, int result) {
  if (result >= 0) return result;
  throw std::runtime_error(std::string(call) + ": " + std::strerror(errno));
}

uint32_t EventsOf(Poller::Interest interest) {
  uint32_t events = EPOLLONESHOT;
  if (interest != Poller::Interest::kWrite) events |= EPOLLIN;
  if (interest != Poller::Interest::kRead) events |= EPOLLOUT;
  return events;
}

}  // namespace

OwnDescriptor::~OwnDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Waker::Waker() : event_(Checked("eventfd", ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))) {}

void Waker::Wake() const {
  // Fails only if the counter is full; then the poller is awake already.
  ::eventfd_write(event_.value(), 1);
}

void Waker::Clear() const {
  eventfd_t count = 0;
  ::eventfd_read(event_.value(), &count);
}

Poller::Poller(std::shared_ptr<Waker> waker)
    : epoll_(Checked("epoll_create1", ::epoll_create1(EPOLL_CLOEXEC))), waker_(std::move(waker)) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = waker_->descriptor();
  Checked("epoll_ctl", ::epoll_ctl(epoll_.value(), EPOLL_CTL_ADD, event.data.fd, &event));
}

void Poller::Arm(int descriptor, Interest interest) {
  epoll_event event{};
  event.events = EventsOf(interest);
  event.data.fd = descriptor;
  if (::epoll_ctl(epoll_.value(), EPOLL_CTL_MOD, descriptor, &event) == 0) return;
  Checked("epoll_ctl", ::epoll_ctl(epoll_.value(), EPOLL_CTL_ADD, descriptor, &event));
}

std::vector<int> Poller::Ready(std::chrono::milliseconds timeout) {
  std::array<epoll_event, kMaxNumEvents> events{};
  const int num_ready = ::epoll_wait(epoll_.value(),
                                     events.data(),
                                     static_cast<int>(events.size()),
                                     static_cast<int>(timeout.count()));
  std::vector<int> ready;
  for (int i = 0; i < num_ready; ++i) {
    const int descriptor = events[static_cast<size_t>(i)].data.fd;
    if (descriptor == waker_->descriptor()) {
      waker_->Clear();
    } else {
      ready.push_back(descriptor);
    }
  }
  return ready;
}

}  // namespace freelsd
