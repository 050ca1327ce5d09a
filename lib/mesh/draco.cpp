#include "mesh/draco.h"

#include <draco/compression/decode.h>

#include <array>
#include <memory>
#include <new>
#include <stdexcept>

#include "core/error.h"

namespace mesh {

namespace {

template <class T>
T checked(const Source& source, draco::StatusOr<T>&& decoded) {
    if (!decoded.ok()) {
        std::string reason = decoded.status().error_msg_string();
        while (reason.ends_with('.')) reason.pop_back();
        throw core::Error(source.name + ": Draco: " + (reason.empty() ? "corrupt" : reason));
    }
    return std::move(decoded).value();
}

// One attribute of the points, if the file has it as numbers with at least three components.
class Attribute {
  public:
    Attribute(const Source& source, const draco::PointCloud& cloud, draco::GeometryAttribute::Type type)
        : source_(source), attribute_(cloud.GetNamedAttribute(type)) {
        // Corrupt bytes give truth values other than 0 and 1, which the decoder reads as bool.
        if (attribute_ != nullptr &&
            (attribute_->num_components() < 3 || attribute_->data_type() == draco::DT_BOOL))
            attribute_ = nullptr;
    }

    bool is_present() const { return attribute_ != nullptr; }
    bool is_single() const { return attribute_->data_type() == draco::DT_FLOAT32; }

    // Throws Error where a corrupt file maps the point to a value that is not there.
    glm::dvec3 at(uint32_t point) const {
        const draco::AttributeValueIndex value = attribute_->mapped_index(draco::PointIndex(point));
        std::array<double, 3> out{};
        if (value.value() >= attribute_->size() ||
            !attribute_->ConvertValue<double>(value, static_cast<int8_t>(out.size()), out.data()))
            throw core::Error(core::text("%s: Draco: vertex %u lacks a value", source_.name.c_str(), point));
        return {out[0], out[1], out[2]};
    }

    // What at() gives for full intensity of a colour.
    double full_colour() const {
        const draco::DataType type = attribute_->data_type();
        const bool is_fraction =
            attribute_->normalized() || type == draco::DT_FLOAT32 || type == draco::DT_FLOAT64;
        return is_fraction ? 1 : type == draco::DT_UINT16 ? 65535 : 255;
    }

  private:
    const Source& source_;
    const draco::PointAttribute* attribute_;
};

// True if the coordinates are relative to an origin.
bool read_points(const Source& source, const draco::PointCloud& cloud, Mesh& mesh) {
    const Attribute position(source, cloud, draco::GeometryAttribute::POSITION);
    const Attribute normal(source, cloud, draco::GeometryAttribute::NORMAL);
    const Attribute colour(source, cloud, draco::GeometryAttribute::COLOR);
    if (!position.is_present()) throw core::Error(source.name + ": Draco: there are no positions");
    std::vector<glm::dvec3> points;
    for (uint32_t v = 0; v < cloud.num_points(); ++v) {
        if (position.is_single())
            mesh.positions.emplace_back(position.at(v));
        else
            points.push_back(position.at(v));
        if (normal.is_present()) mesh.normals.push_back(unit_normal(normal.at(v)));
        if (colour.is_present()) {
            const glm::dvec3 c = colour.at(v) / colour.full_colour();
            mesh.colours.emplace_back(colour_from_fraction(c.x), colour_from_fraction(c.y),
                                      colour_from_fraction(c.z));
        }
    }
    if (!position.is_single()) place_points(points, mesh);
    return !position.is_single();
}

void read_faces(const Source& source, const draco::Mesh& drawn, ReadResult& result) {
    Faces faces(source, drawn.num_points(), result);
    for (uint32_t f = 0; f < drawn.num_faces(); ++f) {
        const draco::Mesh::Face& face = drawn.face(draco::FaceIndex(f));
        faces.polygon(std::array<int64_t, 3>{face[0].value(), face[1].value(), face[2].value()});
    }
}

ReadResult decode(const Source& source, const ReadOptions& options) {
    draco::DecoderBuffer buffer;
    buffer.Init(source.text().data(), source.bytes.size());
    const auto type = checked(source, draco::Decoder::GetEncodedGeometryType(&buffer));
    draco::Decoder decoder;
    ReadResult result;
    result.counts.format = "draco";
    std::unique_ptr<draco::PointCloud> cloud;
    if (type == draco::TRIANGULAR_MESH) {
        std::unique_ptr<draco::Mesh> drawn = checked(source, decoder.DecodeMeshFromBuffer(&buffer));
        read_faces(source, *drawn, result);
        cloud = std::move(drawn);
    } else {
        cloud = checked(source, decoder.DecodePointCloudFromBuffer(&buffer));
    }
    result.counts.vertices_in = cloud->num_points();
    const bool is_placed = read_points(source, *cloud, result.mesh);
    settle_bad_vertices(source, options, is_placed, result);
    return result;
}

}  // namespace

ReadResult read_draco(const Source& source, const ReadOptions& options) {
    try {
        return decode(source, options);
    } catch (const std::bad_alloc&) {
        // The decoder believes some counts of a corrupt file.
        throw core::Error(source.name + ": Draco: the counts of the file need more memory than there is");
    } catch (const std::length_error&) {
        throw core::Error(source.name + ": Draco: the counts of the file are absurd");
    }
}

}  // namespace mesh
