#include "gl/objects.h"

#include <algorithm>

#include "core/error.h"

namespace gl {
namespace {

GLuint make_shader(const Use& gl, GLuint program, GLenum kind, const std::string& source) {
    const GLuint shader = gl->CreateShader(kind);
    const char* const text = source.c_str();
    gl->ShaderSource(shader, 1, &text, nullptr);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    return shader;
}

}  // namespace

GLuint make_program(const Use& gl, const std::string& vertex_source, const std::string& fragment_source) {
    const GLuint program = gl->CreateProgram();
    const GLuint shaders[] = {make_shader(gl, program, GL_VERTEX_SHADER, vertex_source),
                              make_shader(gl, program, GL_FRAGMENT_SHADER, fragment_source)};
    gl->LinkProgram(program);
    GLint is_linked = 0;
    gl->GetProgramiv(program, GL_LINK_STATUS, &is_linked);
    if (!is_linked) {
        std::string log(2048, '\0');
        GLsizei length = 0;
        for (const GLuint shader : shaders) {
            gl->GetShaderInfoLog(shader, GLsizei(log.size()), &length, log.data());
            if (length > 0) break;
        }
        if (length == 0) gl->GetProgramInfoLog(program, GLsizei(log.size()), &length, log.data());
        log.resize(size_t(length));
        std::replace(log.begin(), log.end(), '\n', ' ');
        throw core::Error(gl.device().renderer() + ": refuses a shader: " + log);
    }
    for (const GLuint shader : shaders) gl->DeleteShader(shader);
    return program;
}

Texture::Texture(const Use& gl, const TexelFormat& format) : format_(format) {
    gl->GenTextures(1, &id_);
    bind(gl, 0);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void Texture::grow(const Use& gl, int width, int height) {
    if (width <= width_ && height <= height_) return;
    width_ = std::max(width, width_), height_ = std::max(height, height_);
    bind(gl, 0);
    gl->TexImage2D(GL_TEXTURE_2D, 0, format_.internal, width_, height_, 0, format_.format, format_.type,
                   nullptr);
}

void Texture::bind(const Use& gl, int unit) const {
    gl->ActiveTexture(GLenum(GL_TEXTURE0 + unit));
    gl->BindTexture(GL_TEXTURE_2D, id_);
}

Framebuffer::Framebuffer(const Use& gl, const std::vector<const Texture*>& colours, const Texture* depth) {
    gl->GenFramebuffers(1, &id_);
    gl->BindFramebuffer(GL_FRAMEBUFFER, id_);
    std::vector<GLenum> places;
    for (const Texture* colour : colours) {
        places.push_back(GLenum(GL_COLOR_ATTACHMENT0 + places.size()));
        gl->FramebufferTexture(GL_FRAMEBUFFER, places.back(), colour->id(), 0);
    }
    if (depth) gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth->id(), 0);
    if (places.empty()) {
        gl->DrawBuffer(GL_NONE);
        gl->ReadBuffer(GL_NONE);
    } else {
        gl->DrawBuffers(GLsizei(places.size()), places.data());
    }
}

void Framebuffer::bind(const Use& gl) const {
    gl->BindFramebuffer(GL_FRAMEBUFFER, id_);
    const GLenum status = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
        throw core::Error(gl.device().renderer() +
                          core::text(": cannot draw into such a framebuffer, status 0x%04x", status));
}

void clear_floats(const Use& gl, GLint colour_index) {
    constexpr float kZeros[4] = {};
    gl->ClearBufferfv(GL_COLOR, colour_index, kZeros);
}

void clear_uints(const Use& gl) {
    constexpr GLuint kZeros[4] = {};
    gl->ClearBufferuiv(GL_COLOR, 0, kZeros);
}

void clear_depth(const Use& gl) {
    constexpr float kFarthest = 0;
    gl->ClearBufferfv(GL_DEPTH, 0, &kFarthest);
}

std::vector<Part> parts_of(int width, int height, int most) {
    std::vector<Part> parts;
    for (int y = 0; y < height; y += most)
        for (int x = 0; x < width; x += most)
            parts.push_back({x, y, std::min(most, width - x), std::min(most, height - y)});
    return parts;
}

}  // namespace gl
