#include "core/file_kind.h"

namespace core {

namespace {

struct Kind {
    FileKind kind;
    std::string_view mark;  // the first bytes
    std::string_view name;
};

constexpr Kind kKinds[] = {
    {FileKind::splat_model, "qs-model", "a splat model"},
    {FileKind::splat_model, "qs-coded", "a splat model"},
    {FileKind::progressive_mesh, "qspmesh", "a progressive mesh"},
    {FileKind::qsplat_model, "QSplat", "a model of the original QSplat program"},
    {FileKind::ply, "ply\n", "a PLY file"},
    {FileKind::ply, "ply\r", "a PLY file"},
    {FileKind::draco, "DRACO", "a Draco file"},
    {FileKind::las, "LASF", "a LAS or LAZ cloud of points"},
    {FileKind::e57, "ASTM-E57", "an E57 cloud of points"},
    {FileKind::volume, "ObjectType", "a MetaImage volume"},
    {FileKind::png, "\x89PNG\r\n", "a PNG picture"},
    {FileKind::jpeg, "\xff\xd8\xff", "a JPEG picture"},
    {FileKind::gltf, "glTF", "a glTF scene"},
};

}  // namespace

FileKind file_kind(std::span<const std::byte> beginning) {
    const std::string_view bytes(reinterpret_cast<const char*>(beginning.data()), beginning.size());
    for (const Kind& known : kKinds)
        if (bytes.starts_with(known.mark)) return known.kind;
    return FileKind::unknown;
}

std::string_view name_of(FileKind kind) {
    for (const Kind& known : kKinds)
        if (known.kind == kind) return known.name;
    return {};
}

std::string is_not_wanted(std::span<const std::byte> bytes, std::string_view wanted, std::string_view mark) {
    const std::string not_wanted = "not " + std::string(wanted);
    if (bytes.empty()) return "empty, " + not_wanted;
    const std::string_view is = name_of(file_kind(bytes));
    if (!is.empty() && is != wanted) return std::string(is) + ", " + not_wanted;
    return not_wanted + " (its first bytes are not '" + std::string(mark) + "')";
}

}  // namespace core
