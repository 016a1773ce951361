#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "engine/base/hash.hpp"
#include "engine/scene/files.hpp"
#include "engine/tree/node.hpp"

namespace hoodoo::scene {

/// What reading a file of balls once tells.
struct BallFacts {
  std::filesystem::path path;
  std::size_t size = 0;
  double least_radius = 0;  // [m]
  Digest digest;            // as Balls::digest
};

/// The files of balls that a scene's trees name: CSV, row by row, of any length. A first line names
/// the columns, x,y,z,radius or x,y,z,radius,energy [m, 1]; then each row is a ball.
class BallFiles {
 public:
  /// Both outlive the calls of `check`.
  BallFiles(const Sources& sources, Findings& findings) : sources_(sources), findings_(findings) {}

  /// Reads a file for the node at `where`, once however often it is named, and checks every row.
  /// The least radius; none, and problems found, each with its row, column and value, when it
  /// cannot be read.
  std::optional<double> check(const std::string& file, const std::string& where);
  std::map<std::string, BallFacts> take() { return std::move(known_); }

 private:
  const Sources& sources_;
  Findings& findings_;
  std::map<std::string, BallFacts> known_;
  std::set<std::string> told_;  // places of problems
};

/// The same balls from a file below `folder` that is named by them, made unless it is there; its
/// names go to `kept`. `memory` [bytes] is for sorting. Errors: io.
tree::Balls in_file(const tree::Balls& balls, const std::filesystem::path& folder,
                    std::size_t memory, std::set<std::filesystem::path>& kept);
/// How many balls may be held in so many bytes.
std::size_t most_balls_in(std::size_t memory);

/// Balls of checked files: in memory where they take `most` bytes there at the most, else in a file
/// below `folder` that is made unless it is there, sorted with about `memory` bytes.
class BallLoader {
 public:
  BallLoader(std::map<std::string, BallFacts> files, std::filesystem::path folder, std::size_t most,
             std::size_t memory)
      : files_(std::move(files)), folder_(std::move(folder)), most_(most), memory_(memory) {}

  /// Gives every node below that names a file its balls. Errors: io, not_found; bad_input where a
  /// file is not any more what it was when it was checked.
  void load(tree::Node& tree);
  /// Names of the files in use below `folder`.
  const std::set<std::filesystem::path>& kept() const { return kept_; }

 private:
  tree::Balls balls(const std::string& file);

  std::map<std::string, BallFacts> files_;
  std::filesystem::path folder_;
  std::size_t most_, memory_;
  std::map<std::string, tree::Balls> loaded_;
  std::set<std::filesystem::path> kept_;
};

}  // namespace hoodoo::scene
