// Pictures put into the window, as textures.
#pragma once

#include <memory>

#include "gl/objects.h"
#include "view/picture.h"

namespace qs_view {

// Of a device that is current as long as it lives.
class Canvas {
  public:
    explicit Canvas(const gl::Use& gl);

    // Fills the window: what is not covered by the picture is of its background.
    void clear(const glm::ivec2& size_px, const glm::u8vec3& colour);
    // A picture of another size than the window is stretched as far as it goes in both ways.
    void put(const view::Picture& picture);
    // A round glass about its place in the picture.
    void put_lens(const view::LensPicture& lens, const glm::dvec2& centre_px);

  private:
    struct Image {
        GLuint texture = 0;
        uint64_t number = 0;  // of the picture in it
    };
    void upload(Image& image, const render::Frame& frame);
    // Pixels of the window.
    void draw(const Image& image, const glm::dvec2& corner, const glm::dvec2& size, bool is_round);

    const gl::Use& gl_;
    GLuint program_, vertices_ = 0;
    Image picture_, lens_;
    glm::ivec2 size_px_{1};
};

}  // namespace qs_view
