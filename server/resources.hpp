#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "engine/scene/scene.hpp"

/// Options that several subcommands share.
namespace hoodoo {

/// What a bake may take of the machine.
struct Resources {
  int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::size_t memory_mib = 1024;

  void add_to(CLI::App& command) {
    command.add_option("--threads", threads, "Worker threads")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    command.add_option("--memory", memory_mib, "Memory budget [MiB]")
        ->check(CLI::Range(std::size_t{64}, std::size_t{1} << 24))
        ->capture_default_str();
  }
};

/// Where a scene may look for files.
inline void add_sources(CLI::App& command, std::string* base, std::vector<std::string>* roots) {
  command.add_option("--base", *base, "Where relative paths start; else the scene's own folder");
  command.add_option("--root", *roots, "Folder below which all files of the scene must lie");
}

inline scene::Sources sources_of(const std::filesystem::path& scene, const std::string& base,
                                 const std::vector<std::string>& roots) {
  scene::Sources sources;
  const auto beside = scene.parent_path();
  if (!base.empty()) {
    sources.base = base;
  } else {
    sources.base = beside.empty() ? std::filesystem::path(".") : beside;
  }
  for (const auto& root : roots) sources.roots.emplace_back(root);
  return sources;
}

}  // namespace hoodoo
