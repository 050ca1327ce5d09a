#include "gl/picture.h"

#include <bit>
#include <limits>

#include "core/error.h"
#include "core/parallel.h"

namespace gl {

void check_samples(const render::Look& look) {
    if (look.samples_across != 1) throw core::Error("OpenGL draws one sample a pixel; the CPU draws more");
}

void read_part(const Use& gl, const Part& part, int step, double unit, const render::Look& look,
               std::vector<uint32_t>& buffer, render::Frame& frame) {
    const size_t row_length = 2 * size_t(part.width) * size_t(step);
    buffer.resize(row_length * size_t(part.height) * size_t(step));
    gl->PixelStorei(GL_PACK_ALIGNMENT, 4);
    gl->ReadPixels(0, 0, part.width * step, part.height * step, kUints2.format, kUints2.type, buffer.data());
    gl.check("reading a picture");
    if (look.has_alpha()) frame.alpha.resize(frame.depth.size());
    const auto unit_depth = static_cast<float>(unit);
    core::parallel_for(size_t(part.height), [&](size_t y) {
        const uint32_t* texel =
            buffer.data() + (y * size_t(step) + size_t(step / 2)) * row_length + size_t(step / 2) * 2;
        const size_t at = (size_t(part.y) + y) * size_t(frame.width) + size_t(part.x);
        uint8_t* rgb = frame.rgb.data() + 3 * at;
        for (int x = 0; x < part.width; ++x, texel += 2 * step, rgb += 3) {
            const bool is_drawn = texel[1] != 0;
            const uint32_t colour = texel[1];
            frame.depth[at + size_t(x)] = is_drawn ? unit_depth / std::bit_cast<float>(texel[0])
                                                   : std::numeric_limits<float>::infinity();
            for (int k = 0; k < 3; ++k) rgb[k] = is_drawn ? uint8_t(colour >> (8 * k)) : look.background[k];
            if (look.has_alpha()) frame.alpha[at + size_t(x)] = is_drawn ? 255 : look.background_alpha;
        }
    });
}

}  // namespace gl
