#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "server/job/child.hpp"

/// server/http: routes; the only place that knows status codes.
namespace hoodoo::http {

struct Settings {
  std::string host = "127.0.0.1";                // an IPv6 address may stand in brackets
  int port = 8080;                               // 0: any that is free
  std::filesystem::path data;                    // jobs and their tilesets
  std::filesystem::path cache;                   // finished tiles shared with others; empty: none
  std::vector<std::filesystem::path> tilesets;   // finished ones to stream: folders, .3tz archives
  std::vector<std::filesystem::path> roots;      // where a job's scene may find elevations
  std::size_t connections = 4096;                // at once, a third of the descriptors at most
  int threads = 1;                               // of a bake
  std::size_t memory = std::size_t{1024} << 20;  // [bytes] of a bake
  int at_once = 1;                               // jobs that run
  std::size_t most_waiting = 100;                // jobs
  job::Limits limits;                            // of a job's process
  std::chrono::seconds keep{0};                  // a job that has ended; 0: until it is deleted
  std::uint64_t free_space = std::uint64_t{64} << 20;   // [bytes] that the disk keeps
  std::chrono::seconds keep_assets{0};                  // that no job uses; 0: until deleted
  std::uint64_t asset_space = std::uint64_t{64} << 30;  // [bytes] of assets
  std::chrono::seconds upload_patience{86400};          // with an upload that nothing is added to
  std::filesystem::path program;                        // hoodoo, which carries jobs out
  /// How clients reach the server, "https://terrain.example.org"; empty: the address it listens on.
  std::string public_url;
  std::filesystem::path viewer;  // the viewer's files; empty: beside the command
  /// Who may use it, as Keys reads them; empty: everybody on this machine.
  std::filesystem::path keys;
  bool json_log = false;
  std::vector<std::string> callbacks;     // hosts that may be called, as AllowList has them
  std::vector<std::string> sources;       // HOST[:PORT] that elevations may be fetched from
  std::filesystem::path callback_secret;  // of their signatures
  std::chrono::milliseconds callback_pause{10'000};  // between the first two tries
  /// After `stop`, how long requests are still answered while /readyz says that no more are wanted.
  std::chrono::seconds drain{0};
  std::function<void(int port)> listening;  // called once, when requests are answered
  std::stop_token stop;
};

/// Serves until `stop`. A bake that runs then is stopped, and goes on when a server opens the
/// same data again.
///
/// On a loopback address only requests for a loopback host or the public one are answered, so
/// that no page can reach the server through a name of its own.
/// Errors: bad_input (public_url; it is needed when listening on all addresses; no keys on an
/// address that others can reach; callbacks without a secret), not_found (a root, a tileset), io
/// (the address or the data are in use).
void serve(const Settings& settings);

}  // namespace hoodoo::http
