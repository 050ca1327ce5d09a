// Objects of GL, which live as long as their device: what draws has a device of its own.
#pragma once

#include <string>
#include <vector>

#include "gl/device.h"

namespace gl {

// A linked program.  Throws core::Error with the driver's log.
GLuint make_program(const Use& gl, const std::string& vertex_source, const std::string& fragment_source);

// What a texel holds, as glTexImage2D wants to know it.
struct TexelFormat {
    GLint internal;
    GLenum format, type;
};
inline constexpr TexelFormat kFloats4{GL_RGBA32F, GL_RGBA, GL_FLOAT};
inline constexpr TexelFormat kFloat{GL_R32F, GL_RED, GL_FLOAT};
inline constexpr TexelFormat kUints2{GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT};
inline constexpr TexelFormat kDepth{GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT};

// A picture that is drawn into, and fetched from texel by texel.
class Texture {
  public:
    Texture(const Use& gl, const TexelFormat& format);
    // At least that large from now on; contents of no matter.
    void grow(const Use& gl, int width, int height);
    void bind(const Use& gl, int unit) const;
    GLuint id() const { return id_; }

  private:
    TexelFormat format_;
    GLuint id_ = 0;
    int width_ = 0, height_ = 0;
};

// Textures that are drawn into together.  `depth` may be null.
class Framebuffer {
  public:
    Framebuffer(const Use& gl, const std::vector<const Texture*>& colours, const Texture* depth);
    // Throws core::Error where the driver cannot draw into such textures.
    void bind(const Use& gl) const;

  private:
    GLuint id_ = 0;
};

// Of what is bound: everything 0, which as a depth is farther than all else.
void clear_floats(const Use& gl, GLint colour_index);
void clear_uints(const Use& gl);
void clear_depth(const Use& gl);

// The part of a picture that is drawn at a time, in pixels: textures are not larger.
struct Part {
    int x, y, width, height;
};
std::vector<Part> parts_of(int width, int height, int most);

}  // namespace gl
