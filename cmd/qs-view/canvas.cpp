#include "qs-view/canvas.h"

#include <algorithm>
#include <array>

namespace qs_view {

namespace {

constexpr const char* kVertex = R"(#version 330 core
uniform vec2 corner, size;  // of the window: from -1 to 1, y up
out vec2 place;             // in the picture: from 0 to 1, y down
void main() {
    place = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(corner + place * size, 0.0, 1.0);
}
)";

constexpr const char* kFragment = R"(#version 330 core
uniform sampler2D picture;
uniform float radius;  // of a glass, in parts of the picture; 0: all of it
in vec2 place;
out vec4 colour;
void main() {
    float from_middle = length(place - 0.5);
    if (radius > 0.0 && from_middle > radius) discard;
    colour = vec4(texture(picture, place).rgb, 1.0);
    if (radius > 0.0 && from_middle > 0.98 * radius) colour = vec4(0.8, 0.8, 0.8, 1.0);
}
)";

}  // namespace

Canvas::Canvas(const gl::Use& gl) : gl_(gl), program_(gl::make_program(gl, kVertex, kFragment)) {
    gl_->GenVertexArrays(1, &vertices_);
    for (Image* image : {&picture_, &lens_}) {
        gl_->GenTextures(1, &image->texture);
        gl_->BindTexture(GL_TEXTURE_2D, image->texture);
        // A picture of the window's size is shown pixel by pixel, whatever the filter.
        gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    gl_.check("making the canvas");
}

void Canvas::clear(const glm::ivec2& size_px, const glm::u8vec3& colour) {
    size_px_ = size_px;
    gl_->BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl_->Viewport(0, 0, size_px.x, size_px.y);
    const std::array<float, 4> linear{float(colour.r) / 255, float(colour.g) / 255, float(colour.b) / 255, 1};
    gl_->ClearBufferfv(GL_COLOR, 0, linear.data());
}

void Canvas::upload(Image& image, const render::Frame& frame) {
    gl_->ActiveTexture(GL_TEXTURE0);
    gl_->BindTexture(GL_TEXTURE_2D, image.texture);
    gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl_->TexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, frame.width, frame.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
                    frame.rgb.data());
}

void Canvas::draw(const Image& image, const glm::dvec2& corner, const glm::dvec2& size, bool is_round) {
    const glm::dvec2 window(size_px_);
    const auto uniform = [&](const char* name) { return gl_->GetUniformLocation(program_, name); };
    gl_->UseProgram(program_);
    gl_->Disable(GL_DEPTH_TEST);
    gl_->Disable(GL_BLEND);
    gl_->ActiveTexture(GL_TEXTURE0);
    gl_->BindTexture(GL_TEXTURE_2D, image.texture);
    gl_->Uniform1i(uniform("picture"), 0);
    gl_->Uniform1f(uniform("radius"), is_round ? 0.5f : 0.0f);
    gl_->Uniform2f(uniform("corner"), float(2 * corner.x / window.x - 1), float(1 - 2 * corner.y / window.y));
    gl_->Uniform2f(uniform("size"), float(2 * size.x / window.x), float(-2 * size.y / window.y));
    gl_->BindVertexArray(vertices_);
    gl_->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    gl_.check("showing a picture");
}

void Canvas::put(const view::Picture& picture) {
    if (picture_.number != picture.number) {
        upload(picture_, picture.frame);
        picture_.number = picture.number;
    }
    const glm::dvec2 window(size_px_), size(picture.frame.width, picture.frame.height);
    const double factor = std::min(window.x / size.x, window.y / size.y);
    draw(picture_, 0.5 * (window - factor * size), factor * size, false);
}

void Canvas::put_lens(const view::LensPicture& lens, const glm::dvec2& centre_px) {
    upload(lens_, lens.frame);
    const glm::dvec2 size(lens.frame.width, lens.frame.height);
    draw(lens_, centre_px - 0.5 * size, size, true);
}

}  // namespace qs_view
