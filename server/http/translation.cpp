#include "server/http/translation.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "server/http/head.hpp"
#include "server/http/log.hpp"

namespace hoodoo::http {
namespace {

using namespace std::chrono_literals;

constexpr auto between_looks = 250ms;  // for more of a stream

/// Sends a file in pieces, so that memory does not grow with it.
bool send_piece(const FilePart& part, std::size_t offset, std::size_t length,
                httplib::DataSink& sink) {
  std::array<char, 1 << 16> piece;
  const auto got = ::pread(*part.file, piece.data(), std::min(length, piece.size()),
                           static_cast<off_t>(part.offset + offset));
  return got > 0 && sink.write(piece.data(), static_cast<std::size_t>(got));
}

/// Called while the library sends, where nothing catches.
bool send_more(const std::function<std::optional<std::string>()>& more, httplib::DataSink& sink) {
  std::optional<std::string> piece;
  try {
    piece = more();
  } catch (const std::exception& error) {
    log_fault(std::string("a stream was ended: ") + error.what(), "");
    return false;
  }
  if (!piece) {
    sink.done();
  } else if (piece->empty()) {
    std::this_thread::sleep_for(between_looks);
  } else {
    return sink.write(piece->data(), piece->size());
  }
  return sink.is_writable();
}

}  // namespace

Request read_head(const httplib::Request& from) {
  Request request;
  request.method = from.method;
  request.path = from.path;
  request.peer = from.remote_addr;
  const auto question = from.target.find('?');
  if (question != from.target.npos) request.query = from.target.substr(question + 1);
  for (const auto& header : from.headers) {
    auto name = header.first;
    std::ranges::transform(name, name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (name == range_within) {
      if (request.method != "GET") continue;  // means nothing to others: RFC 9110, 14.2
      name = "range";
    }
    auto& value = request.headers[name];
    value += (value.empty() ? "" : ", ") + header.second;
  }
  return request;
}

void write(Response&& from, httplib::Response& to, const std::stop_token& stop) {
  if (from.take) from = from.take([](const UsePiece&) { return Received::whole; });  // no body
  while (from.later) {
    if (auto ready = from.later(stop.stop_requested())) {
      from = std::move(*ready);
    } else {
      std::this_thread::sleep_for(50ms);
    }
  }
  if (from.held && !from.body.empty()) {
    from.text = std::make_shared<const std::string>(std::move(from.body));
  }
  // The library sends nothing piece by piece any more when it is to end.
  if (from.text && stop.stop_requested()) from.body = *std::exchange(from.text, nullptr);
  to.status = from.status;
  for (auto& [name, value] : from.headers) to.set_header(name, value);
  // Else the library says of every HEAD that ranges are served: taken away again by `finish`.
  if (from.header("Accept-Ranges").empty()) to.set_header("Accept-Ranges", "none");
  if (from.more) {
    to.set_chunked_content_provider(
        from.type,
        [more = from.more](std::size_t, httplib::DataSink& sink) { return send_more(more, sink); });
  } else if (from.part && from.part->length > 0) {
    to.set_content_provider(
        from.part->length, from.type,
        [part = *from.part](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
          return send_piece(part, offset, length, sink);
        });
  } else if (from.text) {
    const auto size = from.text->size();
    to.set_content_provider(size, from.type,
                            [text = std::move(from.text), held = std::move(from.held)](
                                std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                              return sink.write(text->data() + offset, length);
                            });
  } else if (!from.type.empty()) {
    to.set_content(std::move(from.body), from.type);
  }
}

}  // namespace hoodoo::http
