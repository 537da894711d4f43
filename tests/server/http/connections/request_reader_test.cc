#include "server/http/connections/request_reader.h"

#include <chrono>

#include <doctest/doctest.h>

namespace freelsd {
namespace {

using State = RequestReader::State;

constexpr char kChunkedHead[] =
    "POST /x HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n";

RequestRules Strict() {
  RequestRules rules;
  rules.max_small_body_bytes = 100;
  rules.takes_large_bodies = false;
  return rules;
}

// State after each of the bytes arrived alone; `buffered` is what is left.
State AfterEachByte(RequestReader& reader, const std::string& text, std::string& buffered) {
  State state = State::kNothing;
  for (const char byte : text) {
    buffered.push_back(byte);
    state = reader.Advance(buffered);
  }
  return state;
}

TEST_CASE("request reader: a request that arrives byte by byte is whole with its last byte") {
  const RequestRules rules = Strict();
  RequestReader reader(rules);
  std::string buffered;
  const std::string head = "\r\nPOST /x HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\n";
  CHECK(AfterEachByte(reader, "\r\n", buffered) == State::kNothing);
  CHECK(AfterEachByte(reader, head.substr(2, head.size() - 3), buffered) == State::kHead);
  CHECK(AfterEachByte(reader, "\nab", buffered) == State::kBody);
  CHECK(AfterEachByte(reader, "c", buffered) == State::kWhole);
  CHECK(buffered == "abc");
  CHECK(reader.head().target == "/x");
}

TEST_CASE("request reader: many blank lines before a request take no time") {
  constexpr size_t kNumBlank = 2'000'000;
  const RequestRules rules = Strict();
  RequestReader reader(rules);
  std::string buffered;
  for (size_t i = 0; i < kNumBlank; ++i) buffered += "\r\n";
  const auto begin = std::chrono::steady_clock::now();
  CHECK(reader.Advance(buffered) == State::kNothing);
  // Erased one by one, they would take minutes.
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(2));
}

TEST_CASE("request reader: two requests at once are found one after the other") {
  const RequestRules rules = Strict();
  RequestReader reader(rules);
  const std::string request = "GET /x HTTP/1.1\r\nHost: localhost\r\n\r\n";
  std::string buffered = request + request;
  CHECK(reader.Advance(buffered) == State::kWhole);
  CHECK(buffered == request);
  reader.Reset();
  CHECK(reader.Advance(buffered) == State::kWhole);
  reader.Reset();
  CHECK(reader.Advance(buffered) == State::kNothing);
}

TEST_CASE("request reader: the end of a chunked body is found, with and without trailers") {
  const RequestRules rules = Strict();
  for (const std::string body : {"0\r\n\r\n",
                                 "3\r\nabc\r\n0\r\n\r\n",
                                 "3;x=y\r\nabc\r\nA\r\n0123456789\r\n0\r\nT: 1\r\n\r\n",
                                 "4\r\n\r\n\r\n\r\n0\r\n\r\n"}) {
    CAPTURE(body);
    RequestReader reader(rules);
    std::string buffered;
    CHECK(AfterEachByte(reader, kChunkedHead + body.substr(0, body.size() - 1), buffered) ==
          State::kBody);
    CHECK(AfterEachByte(reader, body.substr(body.size() - 1), buffered) == State::kWhole);
    CHECK(buffered == body);
  }
}

TEST_CASE("request reader: malformed chunks and bodies beyond the limit are refused") {
  const RequestRules rules = Strict();
  for (const std::string body : {"-2\r\n", "\r\n", "x\r\n", "1234567890123\r\n", "100\r\n"}) {
    CAPTURE(body);
    RequestReader reader(rules);
    std::string buffered = kChunkedHead + body + std::string(200, 'a');
    CHECK_THROWS_AS(reader.Advance(buffered), ApiError);
  }
  RequestReader reader(rules);
  std::string buffered = "POST /x HTTP/1.1\r\nHost: localhost\r\nContent-Length: 101\r\n\r\n";
  CHECK_THROWS_AS(reader.Advance(buffered), ApiError);
}

TEST_CASE("request reader: where large bodies are taken, chunked ones count as large") {
  RequestRules rules = Strict();
  rules.takes_large_bodies = true;
  for (const std::string& head :
       {std::string(kChunkedHead),
        std::string("POST /x HTTP/1.1\r\nHost: localhost\r\nContent-Length: 101\r\n\r\n")}) {
    RequestReader reader(rules);
    std::string buffered = head + "1";
    CHECK(reader.Advance(buffered) == State::kLargeBody);
    CHECK(buffered == "1");
  }
}

TEST_CASE("request reader: a client that expects 100 Continue is told once") {
  const RequestRules rules = Strict();
  RequestReader reader(rules);
  std::string buffered =
      "POST /x HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: 2\r\n\r\n";
  CHECK(reader.Advance(buffered) == State::kBody);
  CHECK(reader.MustContinue());
  CHECK_FALSE(reader.MustContinue());
}

}  // namespace
}  // namespace freelsd
