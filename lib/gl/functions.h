// The functions of GL that we call, as found at run time.
#pragma once

#include <GL/glcorearb.h>

#include "gl/context.h"

// X(name without gl, type)
#define QS_GL_FUNCTIONS(X)                                       \
    X(ActiveTexture, PFNGLACTIVETEXTUREPROC)                     \
    X(AttachShader, PFNGLATTACHSHADERPROC)                       \
    X(BindBuffer, PFNGLBINDBUFFERPROC)                           \
    X(BindFramebuffer, PFNGLBINDFRAMEBUFFERPROC)                 \
    X(BindTexture, PFNGLBINDTEXTUREPROC)                         \
    X(BindVertexArray, PFNGLBINDVERTEXARRAYPROC)                 \
    X(BlendFunc, PFNGLBLENDFUNCPROC)                             \
    X(BufferData, PFNGLBUFFERDATAPROC)                           \
    X(CheckFramebufferStatus, PFNGLCHECKFRAMEBUFFERSTATUSPROC)   \
    X(ClearBufferfv, PFNGLCLEARBUFFERFVPROC)                     \
    X(ClearBufferuiv, PFNGLCLEARBUFFERUIVPROC)                   \
    X(CompileShader, PFNGLCOMPILESHADERPROC)                     \
    X(CreateProgram, PFNGLCREATEPROGRAMPROC)                     \
    X(CreateShader, PFNGLCREATESHADERPROC)                       \
    X(DeleteShader, PFNGLDELETESHADERPROC)                       \
    X(DepthFunc, PFNGLDEPTHFUNCPROC)                             \
    X(Disable, PFNGLDISABLEPROC)                                 \
    X(DrawArrays, PFNGLDRAWARRAYSPROC)                           \
    X(DrawArraysInstanced, PFNGLDRAWARRAYSINSTANCEDPROC)         \
    X(DrawBuffer, PFNGLDRAWBUFFERPROC)                           \
    X(DrawBuffers, PFNGLDRAWBUFFERSPROC)                         \
    X(DrawElements, PFNGLDRAWELEMENTSPROC)                       \
    X(Enable, PFNGLENABLEPROC)                                   \
    X(EnableVertexAttribArray, PFNGLENABLEVERTEXATTRIBARRAYPROC) \
    X(FramebufferTexture, PFNGLFRAMEBUFFERTEXTUREPROC)           \
    X(GenBuffers, PFNGLGENBUFFERSPROC)                           \
    X(GenFramebuffers, PFNGLGENFRAMEBUFFERSPROC)                 \
    X(GenTextures, PFNGLGENTEXTURESPROC)                         \
    X(GenVertexArrays, PFNGLGENVERTEXARRAYSPROC)                 \
    X(GetError, PFNGLGETERRORPROC)                               \
    X(GetFloatv, PFNGLGETFLOATVPROC)                             \
    X(GetIntegerv, PFNGLGETINTEGERVPROC)                         \
    X(GetProgramInfoLog, PFNGLGETPROGRAMINFOLOGPROC)             \
    X(GetProgramiv, PFNGLGETPROGRAMIVPROC)                       \
    X(GetShaderInfoLog, PFNGLGETSHADERINFOLOGPROC)               \
    X(GetString, PFNGLGETSTRINGPROC)                             \
    X(GetUniformLocation, PFNGLGETUNIFORMLOCATIONPROC)           \
    X(LinkProgram, PFNGLLINKPROGRAMPROC)                         \
    X(MapBufferRange, PFNGLMAPBUFFERRANGEPROC)                   \
    X(PixelStorei, PFNGLPIXELSTOREIPROC)                         \
    X(ReadBuffer, PFNGLREADBUFFERPROC)                           \
    X(ReadPixels, PFNGLREADPIXELSPROC)                           \
    X(ShaderSource, PFNGLSHADERSOURCEPROC)                       \
    X(TexImage2D, PFNGLTEXIMAGE2DPROC)                           \
    X(TexParameteri, PFNGLTEXPARAMETERIPROC)                     \
    X(Uniform1f, PFNGLUNIFORM1FPROC)                             \
    X(Uniform1i, PFNGLUNIFORM1IPROC)                             \
    X(Uniform2f, PFNGLUNIFORM2FPROC)                             \
    X(Uniform3f, PFNGLUNIFORM3FPROC)                             \
    X(UniformMatrix3fv, PFNGLUNIFORMMATRIX3FVPROC)               \
    X(UnmapBuffer, PFNGLUNMAPBUFFERPROC)                         \
    X(UseProgram, PFNGLUSEPROGRAMPROC)                           \
    X(VertexAttribDivisor, PFNGLVERTEXATTRIBDIVISORPROC)         \
    X(VertexAttribIPointer, PFNGLVERTEXATTRIBIPOINTERPROC)       \
    X(VertexAttribPointer, PFNGLVERTEXATTRIBPOINTERPROC)         \
    X(Viewport, PFNGLVIEWPORTPROC)

namespace gl {

struct Functions {
#define QS_GL_MEMBER(name, type) type name = nullptr;
    QS_GL_FUNCTIONS(QS_GL_MEMBER)
#undef QS_GL_MEMBER

    // Of a context that is current.  Throws core::Error where one is missing.
    explicit Functions(const Context& context);
};

}  // namespace gl
