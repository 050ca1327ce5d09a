// terrain DEM.pgm COLUMNS OUTPUT.ply: a terrain model as a mesh, refined to so many columns.
//
// Heights between the samples are bicubic (Catmull-Rom); noise of up to 2 m, the same in every run, stands
// for the detail that the model has not; colours go by height.  Samples lie 30 m apart.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "mesh/mesh.h"

namespace {

constexpr double kSpacing = 30, kNoise = 2;

struct Heights {
    int width = 0, height = 0;
    std::vector<uint16_t> samples;

    double at(int x, int y) const {
        x = std::clamp(x, 0, width - 1), y = std::clamp(y, 0, height - 1);
        return samples[size_t(y) * size_t(width) + size_t(x)];
    }
};

Heights read_heights(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string magic;
    Heights h;
    int most = 0;
    in >> magic >> h.width >> h.height >> most;
    in.get();
    if (!in || magic != "P5" || most < 256 || h.width < 2 || h.height < 2 || h.width > 65536 ||
        h.height > 65536)
        throw core::Error(path + ": not a PGM of 16 bits");
    h.samples.resize(size_t(h.width) * size_t(h.height));
    for (uint16_t& s : h.samples) {
        const int high = in.get();
        s = uint16_t(high << 8 | in.get());
    }
    if (!in) throw core::Error(path + ": cut off");
    return h;
}

double cubic(double a, double b, double c, double d, double t) {
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

double height_at(const Heights& h, double x, double y) {
    const int ix = int(x), iy = int(y);
    double rows[4];
    for (int k = 0; k < 4; ++k) {
        const int row = iy + k - 1;
        rows[k] = cubic(h.at(ix - 1, row), h.at(ix, row), h.at(ix + 1, row), h.at(ix + 2, row), x - ix);
    }
    return cubic(rows[0], rows[1], rows[2], rows[3], y - iy);
}

// In [-1, 1].
double noise(uint64_t n) {
    n = (n ^ n >> 31) * 0x7fb5d329728ea185u;
    n = (n ^ n >> 27) * 0x81dadef4bc2dd44du;
    return double(n >> 11) * 0x1p-52 - 1;
}

mesh::Mesh terrain(const Heights& h, int columns) {
    const int rows = int((int64_t(columns) - 1) * (h.height - 1) / (h.width - 1)) + 1;
    const double step = double(h.width - 1) / (columns - 1);
    mesh::Mesh mesh;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            const uint64_t n = uint64_t(j) * uint64_t(columns) + uint64_t(i);
            const double z = height_at(h, i * step, j * step);
            mesh.positions.push_back(
                {i * step * kSpacing, (rows - 1 - j) * step * kSpacing, z + kNoise * noise(n)});
            const double share = std::clamp(z / 3000 + 0.05 * noise(~n), 0.0, 1.0);
            mesh.colours.push_back({90 + 130 * share, 110 + 80 * share, 70 + 120 * share});
        }
    for (int j = 0; j + 1 < rows; ++j)
        for (int i = 0; i + 1 < columns; ++i) {
            const auto at = [&](int x, int y) { return uint32_t(y) * uint32_t(columns) + uint32_t(x); };
            mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return mesh;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const int columns = argc == 4 ? std::stoi(argv[2]) : 0;
        if (columns < 2 || columns > 20000)
            throw core::UsageError("usage: terrain DEM.pgm COLUMNS OUTPUT.ply");
        core::OutputFile out(argv[3]);
        out.write(mesh::to_ply(terrain(read_heights(argv[1]), columns)));
        out.commit();
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "terrain: %s\n", e.what());
        return 1;
    }
}
