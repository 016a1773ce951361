#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/base/vector.hpp"
#include "tiling/glb/glb.hpp"
#include "tiling/plan/plan.hpp"

namespace hoodoo::tileset {

/// A point in steps of its level, from the scene origin.
using Position = std::array<std::int64_t, 3>;

/// The tiles of one level put together by exact position, one after another. Inner vertices and
/// edges are counted and forgotten; those in border planes are held until no tile can add to them.
class Seams {
 public:
  /// What is wrong with a level, each with one place where it is.
  struct Fault {
    std::uint64_t count = 0;
    std::string where;
  };
  enum Kind {
    degenerate,  // a triangle without area
    doubled,     // two triangles on the same vertices, or an edge with two faces on one side
    off_plane,   // an edge with one face that lies in no plane between cells
    overfull,    // an edge in a border plane with more than two faces
    normals,     // vertices at one position with different normals
    outside,     // a point outside its tile's columns
    kinds
  };

  Seams(const plan::Lattice& lattice, int level) : lattice_(lattice), level_(level) {}

  /// Tiles come in rows: by y, then by x.
  void add(const plan::Key& key, const glb::Decoded& tile);
  /// Nothing more comes.
  void finish();

  std::uint64_t border_vertices() const { return border_vertices_; }
  /// Edges with one face.
  std::uint64_t open_edges() const { return open_edges_; }
  std::int64_t euler() const { return vertices_ - edges_ + faces_; }
  const std::array<Fault, kinds>& faults() const { return faults_; }
  static const char* describe(Kind kind);

 private:
  struct Welded;
  struct EdgeKey {
    Position low, high;
    friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
  };
  struct Sides {
    std::uint32_t up = 0, down = 0;  // faces that run along the edge from low to high, and back
  };
  struct Hash {
    std::size_t operator()(const Position& p) const;
    std::size_t operator()(const EdgeKey& e) const;
  };

  Welded weld(const glb::Decoded& tile);
  void add_vertices(const Welded& welded);
  void add_edges(const Welded& welded);
  void add_border_edge(const Position& from, const Position& to);
  bool in_cell_plane(const Position& a, const Position& b) const;
  bool in_border_plane(const Position& a, const Position& b) const;
  bool on_border(const Position& p) const { return in_border_plane(p, p); }
  void close_below(std::int64_t y);
  void blame(Kind kind, const Position& where);

  plan::Lattice lattice_;
  int level_;
  std::int64_t row_ = INT64_MIN;
  std::int64_t vertices_ = 0, edges_ = 0, faces_ = 0;
  std::uint64_t border_vertices_ = 0, open_edges_ = 0;
  std::array<Fault, kinds> faults_{};
  std::unordered_map<Position, Vec3f, Hash> border_normals_;
  std::unordered_map<EdgeKey, Sides, Hash> border_edges_;
};

}  // namespace hoodoo::tileset
