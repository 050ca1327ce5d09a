#include "gl/splat_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "gl/objects.h"
#include "gl/picture.h"
#include "gl/shading_source.h"
#include "gl/splat_shaders.h"
#include "gl/triangle_pass.h"
#include "render/splat_record.h"

namespace gl {
namespace {

using render::SplatKind;

// A splat as it lies in a buffer of GL.
struct Splat {
    float place[4];   // centre, radius
    float facing[4];  // normal, flatness
    uint32_t colour;
};
static_assert(sizeof(Splat) == 36);

// Larger ones are drawn as rectangles, which fit a flat outline better and have no upper limit; llvmpipe sets
// a rectangle up in a microsecond more.
constexpr float kMostPointPx = 32;

// Textures are of that many pixels on a side at most.
constexpr int kMostPart = 4096;

// Splats farther away than this many radii are wholly before the eye.
constexpr float kClearRadii = 2;

struct Task {
    std::vector<Splat> points, quads;
    float most_w = 0;  // no inverse depth of theirs is greater
};

// The textures that `smooth` goes through.
struct Smoothing {
    Texture front, normals, colours, lead, lead_depth;
    Framebuffer front_target, normal_target, sum_target, lead_target;

    explicit Smoothing(const Use& gl)
        : front(gl, kDepth),
          normals(gl, kFloats4),
          colours(gl, kFloats4),
          lead(gl, kFloat),
          lead_depth(gl, kDepth),
          front_target(gl, {}, &front),
          normal_target(gl, {&normals}, nullptr),
          sum_target(gl, {&normals, &colours}, nullptr),
          lead_target(gl, {&lead}, &lead_depth) {}

    void grow(const Use& gl, int width, int height, bool with_colours) {
        for (Texture* texture : {&front, &normals, &lead, &lead_depth}) texture->grow(gl, width, height);
        if (with_colours) colours.grow(gl, width, height);
    }
};

}  // namespace

struct SplatPainter::State {
    std::unique_ptr<Device> device;
    render::SetupParams params;
    size_t task_count = 0;
    std::vector<Task> tasks;

    GLuint buffer = 0, point_array = 0, quad_array = 0, screen_array = 0;
    std::unique_ptr<Texture> result, depth;
    std::unique_ptr<Framebuffer> target, resolve_target;
    std::unique_ptr<Smoothing> smoothing;
    std::unique_ptr<TrianglePass> triangles;
    std::map<SplatVariant, GLuint> programs;  // those of the splats
    std::map<SplatVariant, GLuint> resolves;
    std::vector<uint32_t> read_back;

    // Of the frame that is being finished.
    size_t point_count = 0, quad_count = 0;
    bool has_triangles = false;
    float depth_scale = 1;

    void make_arrays(const Use& gl);
    GLuint make_array(const Use& gl, GLuint divisor) const;
    void upload(const Use& gl);
    SplatVariant variant(SplatPass pass, bool quads) const;
    void draw_splats(const Use& gl, const Part& part, SplatPass pass);
    void draw_variant(const Use& gl, const Part& part, const SplatVariant& variant, size_t count);
    void draw_nearest(const Use& gl, const Part& part);
    void draw_smooth(const Use& gl, const Part& part);
    void resolve(const Use& gl);
};

SplatPainter::SplatPainter(std::unique_ptr<Device> device) : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.device = std::move(device);
    const Use gl(*s.device);
    s.result = std::make_unique<Texture>(gl, kUints2);
    s.depth = std::make_unique<Texture>(gl, kDepth);
    s.target = std::make_unique<Framebuffer>(gl, std::vector<const Texture*>{s.result.get()}, s.depth.get());
    s.resolve_target =
        std::make_unique<Framebuffer>(gl, std::vector<const Texture*>{s.result.get()}, nullptr);
    s.triangles = std::make_unique<TrianglePass>(gl, *s.result);
    s.make_arrays(gl);
    gl.check("being set up");
}

SplatPainter::~SplatPainter() = default;

const Device& SplatPainter::device() const {
    return *state_->device;
}

void SplatPainter::State::make_arrays(const Use& gl) {
    gl->GenBuffers(1, &buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    point_array = make_array(gl, 0);
    quad_array = make_array(gl, 1);
    gl->GenVertexArrays(1, &screen_array);
}

// The attributes' places in the buffer are said when it is known where the splats begin.
GLuint SplatPainter::State::make_array(const Use& gl, GLuint divisor) const {
    GLuint array = 0;
    gl->GenVertexArrays(1, &array);
    gl->BindVertexArray(array);
    for (GLuint i = 0; i < 3; ++i) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribDivisor(i, divisor);
    }
    return array;
}

void SplatPainter::begin(const geom::View& view, const render::SplatterOptions& options, size_t task_count) {
    State& s = *state_;
    check_samples(options.look);
    s.params = render::SetupParams(view, options);
    s.task_count = task_count;
    if (s.tasks.size() < task_count) s.tasks.resize(task_count);
    for (size_t i = 0; i < task_count; ++i) {
        s.tasks[i].points.clear();
        s.tasks[i].quads.clear();
        s.tasks[i].most_w = 0;
    }
    s.triangles->begin(task_count);
}

void SplatPainter::add(size_t task, const render::TriangleBatch& batch) {
    state_->triangles->add(state_->params.options, task, batch);
}

void SplatPainter::add(size_t task_index, const render::SplatBatch& batch) {
    const State& s = *state_;
    Task& task = state_->tasks[task_index];
    const auto focal = static_cast<float>(s.params.view.focal_px);
    const float most_point_px = std::min(kMostPointPx, s.device->largest_point());
    for (size_t i = 0; i < size_t(batch.count); ++i) {
        const float x = batch.x[i], y = batch.y[i], z = batch.z[i], radius = batch.radius[i];
        const bool is_clear = z > kClearRadii * radius;
        // At r = radius / z up to 1/2 an outline reaches no further than 2 r (1 + |t|) from its splat's
        // centre.
        const float reach = 2 * (radius / z) * (1 + std::max(std::abs(x), std::abs(y)) / z);
        const bool is_point = is_clear && 2 * reach * focal + 3 < most_point_px;
        (is_point ? task.points : task.quads)
            .push_back({{x, y, z, radius},
                        {batch.nx[i], batch.ny[i], batch.nz[i], batch.flatness[i]},
                        batch.colour[i]});
        task.most_w = std::max(task.most_w, is_clear ? 4 / z : std::max(1.0e6f / radius, z > 0 ? 8 / z : 0));
    }
}

void SplatPainter::State::upload(const Use& gl) {
    std::vector<size_t> point_begins(task_count), quad_begins(task_count);
    point_count = quad_count = 0;
    float most_w = std::numeric_limits<float>::min();
    for (size_t i = 0; i < task_count; ++i) {
        point_begins[i] = point_count, quad_begins[i] = quad_count;
        point_count += tasks[i].points.size(), quad_count += tasks[i].quads.size();
        most_w = std::max(most_w, tasks[i].most_w);
    }
    // A power of two rounds nothing.
    depth_scale = std::ldexp(
        1.0f, -std::clamp(std::ilogb(std::min(most_w, std::numeric_limits<float>::max())) + 1, -126, 126));
    gl->BindBuffer(GL_ARRAY_BUFFER, buffer);
    const size_t size = (point_count + quad_count) * sizeof(Splat);
    if (size == 0) return;
    gl->BufferData(GL_ARRAY_BUFFER, GLsizeiptr(size), nullptr, GL_STREAM_DRAW);
    gl.check(core::text("making room for %zu splats", point_count + quad_count));
    auto* const splats = static_cast<Splat*>(gl->MapBufferRange(
        GL_ARRAY_BUFFER, 0, GLsizeiptr(size), GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT));
    if (!splats) gl.check("mapping a buffer");
    core::parallel_for(task_count, [&](size_t i) {
        const auto copy = [](const std::vector<Splat>& from, Splat* to) {
            if (!from.empty()) std::memcpy(to, from.data(), from.size() * sizeof(Splat));
        };
        copy(tasks[i].points, splats + point_begins[i]);
        copy(tasks[i].quads, splats + point_count + quad_begins[i]);
    });
    gl->UnmapBuffer(GL_ARRAY_BUFFER);
    for (const bool quads : {false, true}) {
        const size_t begin = quads ? point_count * sizeof(Splat) : 0;
        const auto at = [&](size_t offset) { return reinterpret_cast<const void*>(begin + offset); };
        gl->BindVertexArray(quads ? quad_array : point_array);
        gl->VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(Splat), at(offsetof(Splat, place)));
        gl->VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(Splat), at(offsetof(Splat, facing)));
        gl->VertexAttribIPointer(2, 1, GL_UNSIGNED_INT, sizeof(Splat), at(offsetof(Splat, colour)));
    }
}

SplatVariant SplatPainter::State::variant(SplatPass pass, bool quads) const {
    const render::SplatterOptions& options = params.options;
    return {pass,          options.kind, options.look.shade, options.has_colour, params.has_limits(),
            has_triangles, quads};
}

void SplatPainter::State::draw_variant(const Use& gl, const Part& part, const SplatVariant& variant,
                                       size_t count) {
    if (count == 0) return;
    GLuint& program = programs[variant];
    if (program == 0)
        program = make_program(gl, splat_vertex_source(variant), splat_fragment_source(variant));
    gl->UseProgram(program);
    const auto uniform = [&](const char* name) { return gl->GetUniformLocation(program, name); };
    const geom::View& view = params.view;
    const glm::vec2 principal(view.principal());
    set_light(gl, program, params.light);
    gl->Uniform2f(uniform("principal"), principal.x, principal.y);
    gl->Uniform2f(uniform("origin"), float(view.margins.left + part.x), float(view.margins.top + part.y));
    gl->Uniform2f(uniform("size"), float(part.width), float(part.height));
    gl->Uniform1f(uniform("focal"), float(view.focal_px));
    constexpr float kMost = std::numeric_limits<float>::max();
    gl->Uniform2f(uniform("limits"), std::max(params.least_w, -kMost), std::min(params.most_w, kMost));
    gl->Uniform1f(uniform("depth_scale"), depth_scale);
    gl->Uniform1i(uniform("front"), 0);
    gl->Uniform1i(uniform("triangles"), 1);
    gl->Uniform1f(uniform("triangle_lead"), params.triangle_lead);
    if (variant.quads) {
        gl->BindVertexArray(quad_array);
        gl->DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(count));
    } else {
        gl->BindVertexArray(point_array);
        gl->DrawArrays(GL_POINTS, 0, GLsizei(count));
    }
}

void SplatPainter::State::draw_splats(const Use& gl, const Part& part, SplatPass pass) {
    draw_variant(gl, part, variant(pass, false), point_count);
    draw_variant(gl, part, variant(pass, true), quad_count);
}

void SplatPainter::State::draw_nearest(const Use& gl, const Part& part) {
    depth->grow(gl, part.width, part.height);
    target->bind(gl);
    if (!has_triangles) clear_uints(gl);
    clear_depth(gl);
    gl->Enable(GL_DEPTH_TEST);
    draw_splats(gl, part, SplatPass::nearest);
}

void SplatPainter::State::draw_smooth(const Use& gl, const Part& part) {
    if (!smoothing) smoothing = std::make_unique<Smoothing>(gl);
    Smoothing& s = *smoothing;
    // Blending into floats is the dearest part in software.
    const bool has_material = variant(SplatPass::sum, false).has_material();
    s.grow(gl, part.width, part.height, has_material);

    s.front_target.bind(gl);
    clear_depth(gl);
    gl->Enable(GL_DEPTH_TEST);
    draw_splats(gl, part, SplatPass::front);

    s.front.bind(gl, 0);
    (has_material ? s.sum_target : s.normal_target).bind(gl);
    clear_floats(gl, 0);
    if (has_material) clear_floats(gl, 1);
    gl->Disable(GL_DEPTH_TEST);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_ONE, GL_ONE);
    draw_splats(gl, part, SplatPass::sum);
    gl->Disable(GL_BLEND);

    s.lead_target.bind(gl);
    clear_depth(gl);
    gl->Enable(GL_DEPTH_TEST);
    draw_splats(gl, part, SplatPass::lead);
    gl->Disable(GL_DEPTH_TEST);

    resolve(gl);
}

void SplatPainter::State::resolve(const Use& gl) {
    resolve_target->bind(gl);
    if (!has_triangles) clear_uints(gl);
    const SplatVariant key = variant(SplatPass::sum, false);
    GLuint& program = resolves[key];
    if (program == 0) program = make_program(gl, screen_vertex_source(), resolve_source(key));
    gl->UseProgram(program);
    set_light(gl, program, params.light);
    const std::array<std::pair<const char*, const Texture*>, 3> textures{
        {{"normals", &smoothing->normals}, {"colours", &smoothing->colours}, {"lead", &smoothing->lead}}};
    for (size_t unit = 0; unit < textures.size(); ++unit) {
        textures[unit].second->bind(gl, int(unit));
        gl->Uniform1i(gl->GetUniformLocation(program, textures[unit].first), GLint(unit));
    }
    gl->BindVertexArray(screen_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

void SplatPainter::finish(render::Frame& frame) {
    State& s = *state_;
    const geom::View& view = s.params.view;
    frame.resize(view.width, view.height);
    const Use gl(*s.device);
    s.upload(gl);
    s.has_triangles = s.triangles->upload(gl);
    gl->Enable(GL_PROGRAM_POINT_SIZE);
    gl->DepthFunc(GL_GREATER);
    const render::SplatterOptions& options = s.params.options;
    for (const Part& part :
         parts_of(view.width, view.height, std::min(kMostPart, s.device->largest_texture()))) {
        s.result->grow(gl, part.width, part.height);
        gl->Viewport(0, 0, part.width, part.height);
        if (s.has_triangles) {
            s.triangles->draw(gl, s.params, part);
            s.triangles->inverse_depths().bind(gl, 1);
        }
        options.kind == SplatKind::smooth ? s.draw_smooth(gl, part) : s.draw_nearest(gl, part);
        gl.check(core::text("drawing %zu splats and %zu triangles", s.point_count + s.quad_count,
                            s.has_triangles ? s.triangles->count() : 0));
        read_part(gl, part, 1, options.depth_unit, options.look, s.read_back, frame);
    }
}

}  // namespace gl
