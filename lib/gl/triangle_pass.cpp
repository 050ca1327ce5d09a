#include "gl/triangle_pass.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "render/shading.h"

namespace gl {
namespace {

// Nothing nearer to the eye is drawn, in parts of the largest coordinate.
constexpr double kNearest = 1.0e-6;

glm::vec3 material_of(const render::SplatterOptions& options, uint32_t colour) {
    if (options.look.shade == render::Shade::level) return glm::vec3(render::level_colour(0));
    if (!options.has_colour) return glm::vec3(render::kGreyMaterial);
    return {float(colour & 255u), float(colour >> 8 & 255u), float(colour >> 16 & 255u)};
}

}  // namespace

TrianglePass::TrianglePass(const Use& gl, const Texture& result)
    : inverse_depths_(gl, kFloat), depth_(gl, kDepth), target_(gl, {&result, &inverse_depths_}, &depth_) {
    gl->GenVertexArrays(1, &array_);
    gl->BindVertexArray(array_);
    gl->GenBuffers(1, &buffer_);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer_);
    const size_t offsets[3] = {offsetof(Vertex, place), offsetof(Vertex, normal), offsetof(Vertex, material)};
    for (GLuint i = 0; i < 3; ++i) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                                reinterpret_cast<const void*>(offsets[i]));
    }
}

void TrianglePass::begin(size_t task_count) {
    task_count_ = task_count;
    if (tasks_.size() < task_count) tasks_.resize(task_count);
    for (size_t i = 0; i < task_count; ++i) {
        tasks_[i].vertices.clear();
        tasks_[i].largest = 0;
    }
}

void TrianglePass::add(const render::SplatterOptions& options, size_t task_index,
                       const render::TriangleBatch& batch) {
    Task& task = tasks_[task_index];
    for (size_t i = 0; i < size_t(batch.count); ++i) {
        const glm::vec3 m = material_of(options, batch.colour[i]);
        for (size_t k = 0; k < 3; ++k) {
            const float x = batch.x[k][i], y = batch.y[k][i], z = batch.z[k][i];
            task.vertices.push_back(
                {{x, y, z}, {batch.nx[k][i], batch.ny[k][i], batch.nz[k][i]}, {m.x, m.y, m.z}});
            task.largest = std::max({task.largest, std::abs(x), std::abs(y), std::abs(z)});
        }
    }
}

bool TrianglePass::upload(const Use& gl) {
    vertex_count_ = 0, largest_ = 0;
    for (size_t i = 0; i < task_count_; ++i) {
        vertex_count_ += tasks_[i].vertices.size();
        largest_ = std::max(largest_, tasks_[i].largest);
    }
    if (vertex_count_ == 0 || !(largest_ > 0)) return false;
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer_);
    const auto size = GLsizeiptr(vertex_count_ * sizeof(Vertex));
    gl->BufferData(GL_ARRAY_BUFFER, size, nullptr, GL_STREAM_DRAW);
    gl.check(core::text("making room for %zu triangles", count()));
    auto* to = static_cast<Vertex*>(
        gl->MapBufferRange(GL_ARRAY_BUFFER, 0, size, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT));
    if (!to) gl.check("mapping a buffer");
    for (size_t i = 0; i < task_count_; ++i)
        to = std::copy(tasks_[i].vertices.begin(), tasks_[i].vertices.end(), to);
    gl->UnmapBuffer(GL_ARRAY_BUFFER);
    return true;
}

void TrianglePass::draw(const Use& gl, const render::SetupParams& params, const Part& part) {
    for (Texture* texture : {&inverse_depths_, &depth_}) texture->grow(gl, part.width, part.height);
    target_.bind(gl);
    clear_uints(gl);
    clear_floats(gl, 1);
    clear_depth(gl);
    gl->Enable(GL_DEPTH_TEST);
    const TriangleVariant variant{params.options.look.shade, true};
    GLuint& program = programs_[variant];
    if (program == 0) program = make_triangle_program(gl, variant);
    gl->UseProgram(program);
    const double unit = 1 / params.options.depth_unit;
    const double nearest =
        std::max(params.view.near.value_or(0) * unit * (1 - 1e-6), kNearest * double(largest_));
    set_uniforms(gl, program, {params.view, unit, nearest, params.light});
    set_part(gl, program, params.view, part, 1);
    gl->BindVertexArray(array_);
    gl->DrawArrays(GL_TRIANGLES, 0, GLsizei(vertex_count_));
}

}  // namespace gl
