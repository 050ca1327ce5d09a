#include "gl/mesh_painter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "gl/objects.h"
#include "gl/picture.h"
#include "gl/triangle_shaders.h"
#include "render/raster.h"
#include "render/shading.h"

namespace gl {
namespace {

using render::Shade;

// Pixels on a side that are drawn for each one of the frame; odd, so that one of them has its centre.
constexpr int kSteps = 3;

// Textures are of that many pixels on a side at most.
constexpr int kMostPart = 4096;

// Nothing nearer to the eye is drawn, in parts of the scene's extent.
constexpr float kNearest = 1.0e-6f;

constexpr size_t kGrain = 4096;  // vertices handed to a thread at a time

// A vertex's attributes that stay from frame to frame.
struct Look {
    float normal[3];
    float material[3];
};

}  // namespace

struct MeshPainter::State {
    std::unique_ptr<Device> device;
    const mesh::Mesh& mesh;
    double largest_coordinate = 0;
    bool looks_are_grey = false;  // those in the buffer
    std::vector<glm::vec3> normals;
    GLuint array = 0, places = 0, looks = 0;
    std::unique_ptr<Texture> result, depth;
    std::unique_ptr<Framebuffer> target;
    std::map<Shade, GLuint> programs;
    std::vector<uint32_t> read_back;

    State(std::unique_ptr<Device> of, const mesh::Mesh& drawn) : device(std::move(of)), mesh(drawn) {}

    void send_mesh(const Use& gl);
    void send_looks(const Use& gl, bool grey);
    void send_places(const Use& gl, const geom::View& view, double scale) const;
    double scale_of(const geom::View& view) const;
    GLuint program_of(const Use& gl, Shade shade);
};

MeshPainter::MeshPainter(std::unique_ptr<Device> device, const mesh::Mesh& mesh)
    : state_(std::make_unique<State>(std::move(device), mesh)) {
    State& s = *state_;
    const Use gl(*s.device);
    s.result = std::make_unique<Texture>(gl, kUints2);
    s.depth = std::make_unique<Texture>(gl, kDepth);
    s.target = std::make_unique<Framebuffer>(gl, std::vector<const Texture*>{s.result.get()}, s.depth.get());
    s.send_mesh(gl);
    gl.check("sending a mesh");
}

MeshPainter::~MeshPainter() = default;

const Device& MeshPainter::device() const {
    return *state_->device;
}

void MeshPainter::State::send_mesh(const Use& gl) {
    for (const glm::vec3& p : mesh.positions)
        largest_coordinate = std::max(
            {largest_coordinate, std::abs(double(p.x)), std::abs(double(p.y)), std::abs(double(p.z))});
    normals = render::filled_normals(mesh);
    gl->GenVertexArrays(1, &array);
    gl->BindVertexArray(array);
    gl->GenBuffers(1, &places);
    gl->GenBuffers(1, &looks);
    GLuint indices = 0;
    gl->GenBuffers(1, &indices);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(mesh.triangles.size() * sizeof(glm::u32vec3)),
                   mesh.triangles.data(), GL_STATIC_DRAW);
    gl->BindBuffer(GL_ARRAY_BUFFER, places);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
    gl->BindBuffer(GL_ARRAY_BUFFER, looks);
    gl->VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(Look),
                            reinterpret_cast<const void*>(offsetof(Look, normal)));
    gl->VertexAttribPointer(2, 3, GL_FLOAT, GL_FALSE, sizeof(Look),
                            reinterpret_cast<const void*>(offsetof(Look, material)));
    for (GLuint i = 0; i < 3; ++i) gl->EnableVertexAttribArray(i);
    send_looks(gl, false);
}

void MeshPainter::State::send_looks(const Use& gl, bool grey) {
    std::vector<Look> sent(normals.size());
    for (size_t v = 0; v < sent.size(); ++v) {
        const glm::vec3 material =
            grey || mesh.colours.empty() ? glm::vec3(render::kGreyMaterial) : glm::vec3(mesh.colours[v]);
        for (int k = 0; k < 3; ++k) sent[v].normal[k] = normals[v][k], sent[v].material[k] = material[k];
    }
    gl->BindBuffer(GL_ARRAY_BUFFER, looks);
    gl->BufferData(GL_ARRAY_BUFFER, GLsizeiptr(sent.size() * sizeof(Look)), sent.data(), GL_STATIC_DRAW);
    looks_are_grey = grey;
}

// In double up to here, so that what is far from the origin keeps its detail.
void MeshPainter::State::send_places(const Use& gl, const geom::View& view, double scale) const {
    std::vector<glm::vec3> sent(mesh.positions.size());
    core::parallel_pieces(sent.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t v = begin; v < end; ++v) sent[v] = glm::vec3(view.view_from_world(mesh.world(v)) * scale);
    });
    gl->BindBuffer(GL_ARRAY_BUFFER, places);
    gl->BufferData(GL_ARRAY_BUFFER, GLsizeiptr(sent.size() * sizeof(glm::vec3)), sent.data(), GL_STREAM_DRAW);
}

// A power of two that brings the scene near 1.
double MeshPainter::State::scale_of(const geom::View& view) const {
    const glm::dvec3 d = glm::abs(mesh.origin - view.eye);
    const double reach = std::max({d.x, d.y, d.z}) + largest_coordinate;
    return reach > 0 ? std::ldexp(1.0, -std::ilogb(reach)) : 1.0;
}

GLuint MeshPainter::State::program_of(const Use& gl, Shade shade) {
    GLuint& program = programs[shade];
    if (program == 0) program = make_triangle_program(gl, {shade, false});
    return program;
}

void MeshPainter::draw(const geom::View& view, const render::Look& look, render::Frame& frame) {
    State& s = *state_;
    check_samples(look);
    frame.resize(view.width, view.height);
    const Use gl(*s.device);
    const bool grey = look.shade == Shade::level;
    if (grey != s.looks_are_grey) s.send_looks(gl, grey);
    const double scale = s.scale_of(view);
    s.send_places(gl, view, scale);
    const GLuint program = s.program_of(gl, grey ? Shade::lit : look.shade);
    gl->UseProgram(program);
    const double nearest = std::max(view.near.value_or(0) * scale * (1 - 1e-6), double(kNearest));
    const glm::mat3 view_from_world = glm::transpose(glm::dmat3(view.right, view.down, view.forward));
    set_uniforms(gl, program, {view, scale, nearest, render::light_of(look, view), view_from_world});
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_GREATER);
    gl->BindVertexArray(s.array);
    for (const Part& part :
         parts_of(view.width, view.height, std::min(kMostPart, s.device->largest_texture()) / kSteps)) {
        const int width = part.width * kSteps, height = part.height * kSteps;
        for (Texture* texture : {s.result.get(), s.depth.get()}) texture->grow(gl, width, height);
        s.target->bind(gl);
        gl->Viewport(0, 0, width, height);
        clear_uints(gl);
        clear_depth(gl);
        set_part(gl, program, view, part, kSteps);
        gl->DrawElements(GL_TRIANGLES, GLsizei(3 * s.mesh.triangles.size()), GL_UNSIGNED_INT, nullptr);
        gl.check(core::text("drawing %zu triangles", s.mesh.triangles.size()));
        read_part(gl, part, kSteps, 1 / scale, look, s.read_back, frame);
    }
}

}  // namespace gl
