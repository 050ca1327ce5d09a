// Draws a mesh with the library: a model is made of it in memory, and the camera stands where all of it is
// seen.
//
//     draw MESH PICTURE.png
#include <cstdio>

#include "core/error.h"
#include "geom/path.h"
#include "mesh/mesh.h"
#include "render/image.h"
#include "scene/draw.h"
#include "splat/build.h"

int main(int argc, char** argv) try {
    if (argc != 3) throw core::UsageError("give a mesh and the name of a picture");
    core::OutputFile file(core::OutputFile::InMemory{argv[1]});
    splat::build(mesh::read_mesh(argv[1]).mesh, {}, file, argv[1]);
    const splat::Model model(file.read_back());

    scene::ModelPainter painter(model);
    const geom::Sphere bounds = scene::PlacedModel{&model}.bounds();
    const geom::Camera camera = geom::orbit(bounds, {.frames = 1}).front();
    render::Frame frame;
    const scene::DrawReport report = painter.draw(geom::make_view(camera, 1280, 720), {}, frame);

    render::FrameWriter picture(argv[2], render::ImageFormat::png, geom::kDefaultFps);
    picture.write(0, frame);
    picture.finish();
    std::printf("%g pixels of error at most\n", report.counts.error_bound_px);
} catch (const std::exception& error) {
    std::fprintf(stderr, "draw: %s\n", error.what());
    return 1;
}
