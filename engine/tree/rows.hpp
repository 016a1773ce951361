#pragma once
#include <array>

#include "engine/tree/columns.hpp"
#include "engine/tree/ground.hpp"

namespace hoodoo::tree {

/// The lower of `edge` and (1 + s((h - z) scale)) / 2, h, scale and edge those of column 16 i + j:
/// the arithmetic of body.cpp for whole rows, on any instruction set.
void step_rows(const Cube& at, const std::array<float, Columns::count>& h,
               const std::array<float, Columns::count>& scale,
               const std::array<float, Columns::count>& edge, CubeValues out);

/// What an operation makes of F so far and its tree's values: the arithmetic of field.cpp for the
/// first `nx` planes.
void apply_rows(Operation operation, std::size_t nx, CubeValues f,
                std::span<const float, Cube::size> tree);

/// The larger of both.
void unite_rows(std::size_t nx, CubeValues f, std::span<const float, Cube::size> other);

}  // namespace hoodoo::tree
