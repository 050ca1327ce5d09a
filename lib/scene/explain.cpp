#include "scene/explain.h"

#include <cmath>

#include "core/error.h"

namespace scene {

namespace {

using core::text;

unsigned long long number(uint64_t value) {
    return static_cast<unsigned long long>(value);
}

Part colour_part(const splat::CutPlan& plan) {
    switch (plan.colour) {
        case splat::ColourFrom::channel:
            return {"colour channel", true, "16 bits a node are read"};
        case splat::ColourFrom::header:
            return {"colour channel", false, "one colour for all is in the header"};
        case splat::ColourFrom::nowhere:
            break;
    }
    return {"colour channel", false, "the model has none and is drawn in grey"};
}

Part sides_part(const splat::CutCounts& counts) {
    return {"frustum test", true,
            text("of %llu of %llu nodes, none below level %u: what is there is inside of the picture",
                 number(counts.side_tests), number(counts.nodes_visited), counts.side_test_level)};
}

Part depths_part(const geom::View& view) {
    const bool is_used = view.near || view.far;
    return {"near and far", is_used, is_used ? "the camera has them" : "the camera has neither"};
}

Part backface_part(const splat::CutPlan& plan) {
    switch (plan.backfaces) {
        case splat::BackfaceTest::made:
            return {"backface test", true, "the surface is closed"};
        case splat::BackfaceTest::not_wanted:
            return {"backface test", false, "--keep-backfaces was given"};
        case splat::BackfaceTest::open_surface:
            return {"backface test", false, "the surface is open, and both its sides may be seen"};
        case splat::BackfaceTest::cut_open_by_near:
            break;
    }
    return {"backface test", false, "the camera's near may cut the surface open, and its inside is seen"};
}

Part triangles_part(const splat::Model& model, const splat::CutOptions& cut) {
    if (!model.header().has_triangles()) return {"triangles", false, "leaves of the model are points"};
    if (!splat::hands_out_triangles(cut)) return {"triangles", false, "splats stand for all leaves"};
    return {"triangles", true, text("of leaves from %g px on", cut.triangle_px)};
}

Part prefix_part(const splat::Model& model) {
    if (model.is_complete()) return {"test for missing blocks", false, "the model is whole"};
    return {"test for missing blocks", true,
            text("%llu of %llu blocks are there", number(model.blocks_present()),
                 number(model.header().block_count))};
}

Part occlusion_part(const splat::CutCounts& counts, Occlusion occlusion, bool can_hide) {
    if (counts.occlusion_culled > 0)
        return {"occlusion", true,
                text("hides %llu nodes, with all below them", number(counts.occlusion_culled))};
    if (occlusion == Occlusion::off) return {"occlusion", false, "--occlusion off was given"};
    return {"occlusion", false,
            can_hide ? "too little is hidden" : "only the back end cpu can prove what is hidden"};
}

Part blending_part(const render::SplatterOptions& options) {
    const bool is_used = options.kind == render::SplatKind::smooth;
    return {"blending", is_used, is_used ? "of splats that overlap" : "one splat decides each pixel"};
}

Part normals_part(const render::SplatterOptions& options) {
    const bool is_used = render::needs_of(options).normals;
    return {"normals in shading", is_used, is_used ? "--shade needs them" : "--shade flat needs none"};
}

Part colours_part(const render::SplatterOptions& options) {
    if (render::needs_of(options).colours) return {"colours in shading", true, "each splat has its own"};
    return {"colours in shading", false,
            options.has_colour ? "--shade normal shows none" : "all is of one grey"};
}

Part bound_part(const DrawReport& drawn, render::SplatKind kind) {
    if (std::isfinite(drawn.counts.error_bound_px))
        return {"error bound", true, "from the errors in the nodes"};
    const bool leaves_ellipsoids = kind == render::SplatKind::square || kind == render::SplatKind::circle;
    return {"error bound", false,
            leaves_ellipsoids ? "squares and circles reach beyond what the model has bounds for"
                              : "a splat reaches the plane of the eye"};
}

}  // namespace

Part part_of(const Backend& backend) {
    const bool is_used = backend.name != "cpu";
    if (is_used) return {"OpenGL", true, backend.is};
    return {"OpenGL", false, backend.reason.empty() ? "--backend cpu was given" : backend.reason};
}

Explanation explain(ModelPainter& painter, const geom::View& view, const DrawOptions& options) {
    Explanation e;
    render::Frame frame;
    e.frame.cut = options.cut;
    e.frame.draw = painter.draw(view, options, frame);
    const std::vector<ModelPlan> plans = painter.plans();
    for (const auto& [model, plan] : plans) {
        e.models.push_back(model->name());
        for (Part part : {prefix_part(*model), backface_part(plan), colour_part(plan),
                          triangles_part(*model, options.cut)}) {
            if (plans.size() > 1) part.name += " of " + model->name();
            e.parts.push_back(std::move(part));
        }
    }
    const render::SplatterOptions splatter = painter.splatter_options(options);
    for (Part& part : std::vector{sides_part(e.frame.draw.counts), depths_part(view),
                                  occlusion_part(e.frame.draw.counts, options.occlusion, painter.can_hide()),
                                  blending_part(splatter), normals_part(splatter), colours_part(splatter),
                                  bound_part(e.frame.draw, options.kind)})
        e.parts.push_back(std::move(part));
    return e;
}

std::string to_text(const Explanation& e) {
    const splat::CutCounts& c = e.frame.draw.counts;
    const bool by_error = e.frame.cut.by == splat::CutBy::error;
    std::string out;
    const auto line = [&](const char* what, const std::string& text) {
        out += core::text("%-10s ", what) + text + "\n";
    };
    for (const std::string& model : e.models) line("model", model);
    line("draws", text("%llu splats, %llu of them the finest there are, for a threshold of %g px of %s",
                       number(c.splats), number(c.splats - c.closed), e.frame.cut.threshold_px,
                       by_error ? "error" : "diameter"));
    if (c.triangles > 0) line("", text("%llu leaves as triangles", number(c.triangles)));
    if (std::isfinite(c.error_bound_px))
        line("", text("no point of the picture is further than %.3g px from the surface", c.error_bound_px));
    line("visits", text("%llu nodes in %llu of %llu blocks", number(c.nodes_visited),
                        number(c.blocks_touched), number(e.frame.draw.model_blocks)));
    line("culls", text("%llu nodes outside of the picture, %llu facing away; with all below them",
                       number(c.frustum_culled), number(c.backface_culled)));
    for (const bool is_used : {true, false})
        for (const Part& part : e.parts)
            if (part.is_used == is_used) line(is_used ? "uses" : "leaves out", part.name + ": " + part.why);
    return out;
}

core::Json to_json(const Explanation& e) {
    core::Json json = to_json(e.frame);
    json.erase("ms");
    json["parts"] = core::Json::array();
    for (const Part& part : e.parts)
        json["parts"].push_back({{"part", part.name}, {"is_used", part.is_used}, {"why", part.why}});
    return json;
}

}  // namespace scene
