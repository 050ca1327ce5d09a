// What man/qs.5 says in numbers: the tables of the node code, the measured errors of its quantisers, and the
// dump of tests/data/tiny.qs.  Each stands between `.\" table: NAME` and `.\" end`; QS_UPDATE=1 in the
// environment writes them anew instead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "splat/coding/symbol_tables.h"
#include "splat/node.h"
#include "splat/triangle_reader.h"
#include "test_meshes.h"

using namespace splat_test;

namespace {

const std::string kPage = std::string(QS_SOURCE) + "/man/qs.5";

std::string read_page() {
    std::ifstream in(kPage);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

// Holds the lines of a table that change against `expected`.  Preprocessor lines of a .TS stay.
void expect_table(const std::string& name, const std::string& expected) {
    const std::string page = read_page(), start = ".\\\" table: " + name + "\n", stop = ".\\\" end\n";
    const size_t at = page.find(start);
    ASSERT_NE(at, std::string::npos) << name;
    size_t begin = at + start.size();
    const size_t end = page.find(stop, begin);
    ASSERT_NE(end, std::string::npos) << name;
    if (page.compare(begin, 4, ".TS\n") == 0) begin = page.find(".\n", begin) + 2;  // the format's last line
    if (std::getenv("QS_UPDATE"))
        std::ofstream(kPage) << page.substr(0, begin) + expected + page.substr(end);
    else
        EXPECT_EQ(page.substr(begin, end - begin), expected) << name << ": QS_UPDATE=1 writes it anew";
}

std::string shortest(float value) {
    char text[32];
    for (int digits = 1; digits < 10; ++digits) {
        std::snprintf(text, sizeof(text), "%.*g", digits, double(value));
        if (std::strtof(text, nullptr) == value) break;
    }
    return text;
}

double degrees(double radians) {
    return radians * 57.29577951308232;
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// Two digits, rounded up.
std::string bound(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
    return core::text("%.2g", std::ceil(value / unit - 1e-9) * unit);
}

std::vector<glm::dvec3> all_normals(int cone) {
    std::vector<glm::dvec3> normals;
    const splat::Frame frame = splat::frame_about({0, 0, 1});
    for (uint32_t code = 0; code < uint32_t(splat::kNormalSteps * splat::kNormalSteps); ++code)
        normals.emplace_back(splat::decode_normal(code, frame, cone));
    return normals;
}

// The worst angle, in degrees, from a direction within the cone to the nearest code.
double normal_error(int cone) {
    const std::vector<glm::dvec3> codes = all_normals(cone);
    const double least = cone < 0 ? -1 : double(splat::kConeCos[cone]);
    Random random(5);
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
        const double z = least + (1 - least) * (i % 4 == 0 ? 0 : random.unit());  // the rim, and inside
        glm::dvec3 d = random.direction();
        const double across = std::hypot(d.x, d.y), r = std::sqrt(std::max(0.0, 1 - z * z));
        d = {d.x / across * r, d.y / across * r, z};
        double best = -1;
        size_t nearest = 0;
        for (size_t k = 0; k < codes.size(); ++k)
            if (const double dot = glm::dot(codes[k], d); dot > best) best = dot, nearest = k;
        worst = std::max(worst, angle_between(codes[nearest], d));
    }
    return degrees(worst);
}

struct LatticeError {
    double worst = 0, mean_square = 0;
};

// Distances of points of the ball to the nearest lattice point, in parts of its radius; of those on the
// middle plane too, where the children of a flat parent lie.
LatticeError lattice_error(double half_height) {
    std::vector<glm::vec3> points;
    for (int a = 0; a < splat::kAcrossSteps; ++a)
        for (int b = 0; b < splat::kAcrossSteps; ++b)
            for (int c = 0; c < splat::kAlongSteps; ++c) {
                glm::vec3 p(splat::across_step(a), splat::across_step(b), splat::along_step(c));
                if (const float length = glm::length(p); length > 1) p /= length;
                points.push_back(p);
            }
    Random random(6);
    LatticeError error;
    constexpr int kSamples = 20000;
    for (int i = 0; i < kSamples; ++i) {
        glm::dvec3 p = random.direction() * std::cbrt(random.unit());
        p.z *= half_height;
        float least = 10;
        for (const glm::vec3& q : points)
            least = std::min(least, glm::dot(q - glm::vec3(p), q - glm::vec3(p)));
        error.worst = std::max(error.worst, std::sqrt(double(least)));
        error.mean_square += double(least) / kSamples;
    }
    return error;
}

// One line of the dump: offset, bytes, what they are.
std::string dump_line(const Bytes& bytes, size_t at, size_t count, const std::string& what) {
    std::string line = core::text("%04zx", at);
    for (size_t i = 0; i < count; ++i) line += core::text(" %02x", unsigned(bytes[at + i]));
    if (line.size() < 30) line.resize(30, ' ');
    return line + "  " + what + "\n";
}

template <class T>
T take(const Bytes& bytes, size_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

std::string describe_header(const Bytes& b) {
    const splat::Header h = splat::parse_header(b, "tiny.qs");
    std::string out;
    const auto count = [&](size_t at, uint64_t n, const char* what) {
        out += dump_line(b, at, 8, core::text("%llu ", static_cast<unsigned long long>(n)) + what);
    };
    out += dump_line(b, 0, 8, "magic");
    out +=
        dump_line(b, 8, 8, core::text("version %u, blocks from byte %zu on", h.version(), splat::kBlocksAt));
    out += dump_line(b, 16, 8, core::text("blocks of %u bytes, flags %u", h.block_size, h.flags));
    for (int k = 0; k < 3; ++k)
        out += dump_line(b, size_t(24 + 8 * k), 8, core::text("origin %c = %g", 'x' + k, h.origin[k]));
    out += dump_line(b, 48, 8, core::text("scale %.9g", h.scale));
    count(56, h.block_count, h.block_count == 1 ? "block" : "blocks"), count(64, h.node_count, "nodes"),
        count(72, h.leaf_count, "leaves");
    count(80, h.vertices_in, "vertices"), count(88, h.triangles_in, "triangles");
    out += dump_line(b, 96, 4, core::text("%u levels", h.level_count));
    out += dump_line(b, 100, 4, core::text("root: children %u", h.root_children));
    for (int k = 0; k < 3; ++k)
        out += dump_line(b, size_t(104 + 4 * k), 4,
                         core::text("root: normal %c = %.9g", 'x' + k, double(h.root_normal[k])));
    out += dump_line(b, 116, 4, core::text("root: flatness %.9g", double(h.root_flatness)));
    out += dump_line(b, 120, 4, core::text("root: error %.9g", double(h.root_error)));
    out += dump_line(b, 124, 4, core::text("root: cone %d", h.root_cone));
    out += dump_line(b, 128, 4, core::text("root: colour %d,%d,%d", h.colour[0], h.colour[1], h.colour[2]));
    if (h.has_triangles()) {
        out += dump_line(b, 132, 4, core::text("a lattice of %u bits", h.lattice_bits));
        count(136, h.triangle_blocks, "block of triangles");
    }
    return out + dump_line(b, 248, 8, "checksum");
}

// A field of a run, and the bit it begins with.
struct Field {
    size_t at;
    std::string what;
};

// Takes a run apart, from its lowest bit on.
class RunFields {
  public:
    RunFields(std::span<const std::byte> bytes, const splat::TriangleRun& run, uint32_t lattice_bits)
        : bytes_(bytes), run_(run), lattice_bits_(lattice_bits) {}

    std::vector<Field> all() {
        head();
        for (uint32_t t = 0; t < run_.triangles(); ++t) triangle(t);
        for (uint32_t e = 0; e < run_.corners(); ++e) corner(e);
        EXPECT_LT(8 * bytes_.size() - at_, 8u);
        return fields_;
    }

  private:
    uint32_t take(uint32_t count) {
        uint32_t value = 0;
        for (uint32_t i = 0; i < count; ++i, ++at_)
            value |= uint32_t(bytes_[at_ / 8] >> int(at_ % 8) & std::byte{1}) << i;
        return value;
    }

    void head() {
        fields_.push_back({0, core::text("%u bytes", take(splat::kRunSizeBits))});
        fields_.push_back({at_, core::text("%u triangles", take(splat::kRunTriangleBits) + 1)});
        fields_.push_back({at_, core::text("%u corners", take(splat::kRunCornerBits) + 1)});
        EXPECT_EQ(take(splat::kRunShadingBits), 0u);
        position_width_ = take(splat::kPositionWidthBits);
        fields_.push_back({at_ - splat::kPositionWidthBits - splat::kRunShadingBits,
                           core::text("flat, width %u", position_width_)});
        take(splat::kNormalWidthBits);
    }

    void triangle(uint32_t t) {
        const size_t begin = at_;
        const glm::u32vec3 e = run_.entries(t);
        std::string glue;
        const bool is_glued = take(1);
        if (is_glued) {
            uint32_t zeros = 0;
            while (!take(1)) ++zeros;
            const uint32_t back = take(zeros) | 1u << zeros;
            const uint32_t edge = take(1) ? 1 + take(1) : 0;
            glue = core::text(" on edge %u of %u", edge, t - back);
        }
        for (int k = is_glued ? 2 : 0; k < 3; ++k) {
            if (take(1)) {
                EXPECT_EQ(e[k], next_++);
                continue;
            }
            uint32_t width = 0;
            while ((next_ - 1) >> width) ++width;
            EXPECT_EQ(e[k], take(width));
        }
        fields_.push_back({begin, core::text("triangle %u: %u %u %u", t, e.x, e.y, e.z) + glue});
    }

    void corner(uint32_t e) {
        const glm::i64vec3 p = run_.position(e);
        fields_.push_back({at_, core::text("corner %u: %d %d %d", e, int(p.x), int(p.y), int(p.z))});
        const uint32_t width = splat::position_width(position_width_, take(splat::kClassBits), lattice_bits_);
        at_ += 3 * width;
    }

    const std::span<const std::byte> bytes_;
    const splat::TriangleRun& run_;
    const uint32_t lattice_bits_;
    size_t at_ = 0;
    uint32_t next_ = 0, position_width_ = 0;
    std::vector<Field> fields_;
};

std::string describe_triangles(const Bytes& b) {
    const splat::Model model = open_model(b);
    const splat::Header& h = model.header();
    const size_t block = h.block_at(h.node_blocks());
    std::string out = dump_line(b, block, 4, "checksum");
    splat::BlockView nodes;
    nodes.open(model, 0);
    splat::BlockTriangles triangles;
    triangles.open(model, nodes);
    for (const auto& placed : triangles.runs()) {
        EXPECT_FALSE(placed.run.has_normals());
        const size_t begin = block + splat::kTriangleBlockHeader + placed.at, size = placed.run.size_bytes();
        const std::vector<Field> fields =
            RunFields(std::span(b).subspan(begin, size), placed.run, h.lattice_bits).all();
        for (size_t at = 0; at < size; at += 4) {
            const size_t count = std::min<size_t>(4, size - at);
            std::string what;
            for (const Field& field : fields)
                if (field.at / 8 >= at && field.at / 8 < at + count)
                    what += (what.empty() ? "" : ", ") + field.what;
            out += dump_line(b, begin + at, count, what.empty() ? "the same" : what);
        }
    }
    return out;
}

std::string describe_block(const Bytes& b) {
    const splat::Model model = open_model(b);
    const splat::BlockLayout& layout = model.layout();
    const Tree tree = read_tree(model);
    const size_t at = model.header().block_at(0);
    std::string out = dump_line(b, at, 4, "checksum");
    out += dump_line(
        b, at + 4, 4,
        core::text("%d nodes, next group in slot %d", take<uint16_t>(b, at + 4), take<uint16_t>(b, at + 6)));
    out += dump_line(b, at + 8, 8, core::text("of block %d", int(take<uint64_t>(b, at + 8))));
    if (model.header().has_triangles())
        out += dump_line(b, at + 16, 8,
                         core::text("triangles at byte %d of all runs", int(take<uint64_t>(b, at + 16)))) +
               dump_line(b, at + 24, 4, core::text("middle side %.9g", double(take<float>(b, at + 24))));
    const size_t nodes = tree.nodes.size() - 1;
    for (size_t i = 0; i < nodes; ++i) {
        const splat::Node& n = tree.nodes[i + 1];
        const uint16_t v = take<uint16_t>(b, at + layout.attitude + 2 * i);
        out += dump_line(
            b, at + layout.attitude + 2 * i, 2,
            core::text("attitude %zu: %d children, cone %d, normal %d = %.3f %.3f %.3f", i, n.children,
                       n.cone, v >> 5 & 1023, double(n.normal.x), double(n.normal.y), double(n.normal.z)));
    }
    for (size_t i = 0; i < nodes; ++i) {
        const splat::Node& n = tree.nodes[i + 1];
        const uint16_t v = take<uint16_t>(b, at + layout.place + 2 * i);
        out += dump_line(b, at + layout.place + 2 * i, 2,
                         core::text("place %zu: r %d, c %d,%d,%d: r = %.4f, centre %.4f %.4f %.4f", i, v & 15,
                                    (v >> 4 & 127) % 11, (v >> 4 & 127) / 11, v >> 11, double(n.radius),
                                    n.centre.x, n.centre.y, n.centre.z));
    }
    for (size_t i = 0; i < nodes; ++i) {
        const glm::u8vec3 c = splat::decode_colour(take<uint16_t>(b, at + layout.colour + 2 * i));
        out +=
            dump_line(b, at + layout.colour + 2 * i, 2, core::text("colour %zu: %d,%d,%d", i, c.r, c.g, c.b));
    }
    for (size_t i = 0; i < nodes; i += 2) {
        std::string what = "shape";
        for (size_t k = i; k < std::min(i + 2, nodes); ++k)
            what += core::text("%s %zu: flatness %g, error %.4f", k > i ? ";" : "", k,
                               double(tree.nodes[k + 1].flatness), double(tree.nodes[k + 1].error));
        out += dump_line(b, at + layout.shape + i / 2, 1, what);
    }
    return out;
}

// The bytes that a dump shows, the others being 0.
Bytes bytes_of_dump(const std::string& dump, size_t size) {
    Bytes bytes(size);
    std::istringstream lines(dump);
    for (std::string line; std::getline(lines, line);) {
        char* at = line.data();
        size_t offset = std::strtoul(at, &at, 16);
        while (at[0] == ' ' && std::isxdigit(at[1]) && std::isxdigit(at[2]) && (at[3] == ' ' || at[3] == 0))
            bytes.at(offset++) = std::byte(std::strtoul(at, &at, 16));
    }
    return bytes;
}

std::string as_roff(const std::string& text) {
    std::string roff;
    for (const char c : text) roff.append(c == '-' ? 2 : 1, '\\').back() = c;
    return roff;
}

}  // namespace

TEST(QsPage, HasTheCodeTables) {
    std::string rows = "code|radius|flatness|error, flatness 0|1|2|3\n";
    for (int k = 0; k < splat::kRadiusLevels; ++k) {
        rows += core::text("%d|%s|%s", k, shortest(splat::kRadius[k]).c_str(),
                           k < 4 ? shortest(splat::kFlatness[k]).c_str() : "");
        for (const auto& errors : splat::kErrorOfRadius)
            rows.append("|").append(k < 8 ? shortest(errors[k]) : "");
        rows += "\n";
    }
    expect_table("codes", rows);
}

TEST(QsPage, HasTheConesAndTheErrorOfNormalsUnderThem) {
    std::string rows = "index|half\\-angle|cosine|sine|tan_half|worst\n";
    rows += "\\-1|180||||" + bound(normal_error(-1)) + "\n";
    for (int k = 0; k < splat::kConeCount; ++k)
        rows += core::text("%d|%.3g|%s|%s|%s|%s\n", k, degrees(std::acos(double(splat::kConeCos[k]))),
                           shortest(splat::kConeCos[k]).c_str(), shortest(splat::kConeSin[k]).c_str(),
                           shortest(splat::kConeTan[k]).c_str(), bound(normal_error(k)).c_str());
    expect_table("cones", rows);
}

TEST(QsPage, HasTheStepsOfTheLattice) {
    std::string rows;
    rows += core::text("step(u, l) = u * (l + (1 - l) * abs(u))\n");
    rows += core::text("x = step((c0 - %d) * (1 / %d), %g)\n", splat::kAcrossSteps / 2,
                       splat::kAcrossSteps / 2, double(splat::kAcrossLinear));
    rows += core::text("y = step((c1 - %d) * (1 / %d), %g)\n", splat::kAcrossSteps / 2,
                       splat::kAcrossSteps / 2, double(splat::kAcrossLinear));
    rows += core::text("z = step((c2 - %g) * (1 / %d), %g)\n", 0.5 * (splat::kAlongSteps - 1),
                       splat::kAlongSteps / 2, double(splat::kAlongLinear));
    rows += core::text("limit = (1 + %g) * (1 - radius[code])\n", double(splat::kSlack));
    rows += "q = x * x + y * y + z * z\ns = limit,  or where q > 1:  limit / sqrt(q)\n";
    rows += "x = x * s,  y = y * s,  z = z * s\noffset = (x * t1 + y * t2 + z * n) * R\n";
    expect_table("step", rows);
}

TEST(QsPage, HasTheErrorsOfTheOtherQuantisers) {
    const LatticeError ball = lattice_error(1), plate = lattice_error(0.1);
    double radius = 0, error = 0;
    for (int k = 1; k < splat::kRadiusLevels; ++k)
        radius = std::max(radius, double(splat::kRadius[k] / splat::kRadius[k - 1]));
    for (const auto& errors : splat::kErrorOfRadius)
        for (int k = 1; k < 8; ++k) error = std::max(error, double(errors[k] / errors[k - 1]));
    std::string rows = core::text(
        "Measured: a centre that is allowed is at most %s limits from a code's (%s in the square mean);\n"
        "one within a tenth of a limit of the middle plane, at most %s (%s).\n",
        bound(ball.worst).c_str(), bound(std::sqrt(ball.mean_square)).c_str(), bound(plate.worst).c_str(),
        bound(std::sqrt(plate.mean_square)).c_str());
    rows += core::text(
        "A radius from %s R on is rounded up by less than a factor of %s, an error bound by less than %s.\n",
        shortest(splat::kRadius[0]).c_str(), bound(radius).c_str(), bound(error).c_str());
    expect_table("lattice", rows);
}

TEST(QsPage, HasTheErrorOfCornerNormals) {
    Random random(7);
    double worst = 0, sum = 0;
    constexpr int kSamples = 200000;
    for (int i = 0; i < kSamples; ++i) {
        const glm::dvec3 n = random.direction();
        const double angle =
            angle_between(n, glm::dvec3(splat::decode_corner_normal(splat::encode_corner_normal(n))));
        worst = std::max(worst, angle), sum += angle / kSamples;
    }
    expect_table("corner-normals", core::text("Measured: it is at most %s degrees off, %s in the mean.\n",
                                              bound(degrees(worst)).c_str(), bound(degrees(sum)).c_str()));
}

TEST(QsPage, HasTheSymbolsOfCompressedBlocks) {
    const char* const kinds[] = {"group|",          "shape|",    "attitude|",     "radius|",
                                 "normal|",         "along|",    "green|",        "red|",
                                 "blue|",           "bit|",      "glue|",         "entry|",
                                 "position class|", "position|", "normal class|", "corner|"};
    const char* const lanes[] = {"|2",
                                 "|0",
                                 "|1",
                                 "|2",
                                 "|3 (x), 4 (y)",
                                 "|5",
                                 "|2",
                                 "|3",
                                 "|4",
                                 "|2",
                                 "|0",
                                 "|1",
                                 "|3",
                                 "|0 (x), 1 (y), 2 (z)",
                                 "|3",
                                 "|0 (column), 1 (row)"};
    std::string rows = "kind|contexts|symbols|L|lane\n";
    for (size_t k = 0; k < splat::kSymbolKinds; ++k) {
        const splat::SymbolField& f = splat::kSymbolFields[k];
        rows += kinds[k] + core::text("%u|%u|%u", f.contexts, f.symbols, f.bits) + lanes[k] + "\n";
    }
    expect_table("symbols", rows);
}

TEST(QsPage, DumpIsTheFile) {
    const Bytes bytes = read_bytes(std::string(QS_TEST_DATA) + "/tiny.qs");
    const std::string dump = describe_header(bytes) + describe_block(bytes);
    EXPECT_EQ(bytes_of_dump(dump, bytes.size()), bytes) << "the dump shows every byte that is not 0";
    expect_table("dump", as_roff(dump));
}

TEST(QsPage, DumpOfTrianglesIsTheFile) {
    const Bytes bytes = read_bytes(std::string(QS_TEST_DATA) + "/tiny-triangles.qs");
    const std::string dump = describe_header(bytes) + describe_block(bytes) + describe_triangles(bytes);
    EXPECT_EQ(bytes_of_dump(dump, bytes.size()), bytes) << "the dump shows every byte that is not 0";
    expect_table("triangle-dump", as_roff(dump));
}
