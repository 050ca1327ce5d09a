// A mesh drawn by GL's own rasteriser, as render::MeshRaster draws it: an independent witness of what is
// exact.
//
// How it differs from render::MeshRaster: GL rounds vertices to some 1/256 px of what it draws, so that each
// pixel is drawn as kSteps x kSteps and the middle one is taken (dragon at 1280 x 720: 81 dB from MeshRaster,
// with one step 59); interpolates in single precision; and of what is nearer to the eye than a millionth of
// the scene's extent nothing is drawn.
#pragma once

#include <memory>

#include "gl/device.h"
#include "mesh/mesh.h"
#include "render/backend.h"

namespace gl {

class MeshPainter final : public render::MeshPainter {
  public:
    // `mesh` lives longer.
    MeshPainter(std::unique_ptr<Device> device, const mesh::Mesh& mesh);
    ~MeshPainter() override;

    const Device& device() const;

    // Throws core::Error where GL fails.
    void draw(const geom::View& view, const render::Look& look, render::Frame& frame) override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace gl
