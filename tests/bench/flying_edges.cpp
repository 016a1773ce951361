#include "tests/bench/flying_edges.hpp"

#include <stdlib.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

namespace hoodoo::bench {

struct FlyingEdges::Pipeline {
  vtkNew<vtkImageData> image;
  vtkNew<vtkFloatArray> values;
  vtkNew<vtkFlyingEdges3D> edges;
};

FlyingEdges::FlyingEdges(std::vector<float>& values, const std::array<int, 3>& size)
    : pipeline_(std::make_unique<Pipeline>()) {
  setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 0);  // which VTK reads when it first runs
  auto& p = *pipeline_;
  p.values->SetArray(values.data(), static_cast<vtkIdType>(values.size()), 1);
  p.image->SetDimensions(size[0], size[1], size[2]);
  p.image->GetPointData()->SetScalars(p.values);
  p.edges->SetInputData(p.image);
  p.edges->SetValue(0, 0);
  p.edges->ComputeNormalsOn();
  p.edges->ComputeGradientsOff();
}

FlyingEdges::~FlyingEdges() = default;

std::size_t FlyingEdges::run() {
  pipeline_->edges->Modified();
  pipeline_->edges->Update();
  return static_cast<std::size_t>(pipeline_->edges->GetOutput()->GetNumberOfPolys());
}

}  // namespace hoodoo::bench
