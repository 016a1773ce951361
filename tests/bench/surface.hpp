#pragma once

namespace hoodoo::bench {

/// Field, Hermite data and surface of two landscapes against the algorithm of Paris et al. 2019.
void compare_surface();
/// A ready grid's surface with normals against vtkFlyingEdges3D, where VTK is there.
void compare_ready_grid();

}  // namespace hoodoo::bench
