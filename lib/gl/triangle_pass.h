// The triangles of a frame, drawn by GL before its splats.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "gl/objects.h"
#include "gl/triangle_shaders.h"
#include "render/splat_record.h"

namespace gl {

class TrianglePass {
  public:
    // Draws into `result`, of kUints2, which lives longer.
    TrianglePass(const Use& gl, const Texture& result);

    // As those of render::SplatPainter.
    void begin(size_t task_count);
    void add(const render::SplatterOptions& options, size_t task, const render::TriangleBatch& batch);

    // Sends what was added, 108 bytes a triangle.  False: there is nothing to be drawn.
    bool upload(const Use& gl);
    // Draws it over all of a part, whose size the result has.
    void draw(const Use& gl, const render::SetupParams& params, const Part& part);
    // Inverse depths of what was drawn, 0 elsewhere.
    const Texture& inverse_depths() const { return inverse_depths_; }
    size_t count() const { return vertex_count_ / 3; }

  private:
    // As it lies in a buffer of GL.
    struct Vertex {
        float place[3], normal[3], material[3];
    };
    struct Task {
        std::vector<Vertex> vertices;
        float largest = 0;  // coordinate
    };
    std::vector<Task> tasks_;
    size_t task_count_ = 0, vertex_count_ = 0;
    float largest_ = 0;
    GLuint buffer_ = 0, array_ = 0;
    Texture inverse_depths_, depth_;
    Framebuffer target_;
    std::map<TriangleVariant, GLuint> programs_;
};

}  // namespace gl
