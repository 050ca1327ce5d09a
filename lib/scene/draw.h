// Drawing models: their cuts for a view, splatted into one frame.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "geom/camera.h"
#include "geom/occlusion.h"
#include "geom/similarity.h"
#include "render/frame.h"
#include "render/splatter.h"
#include "scene/occlusion_choice.h"
#include "splat/cut.h"
#include "splat/model.h"

namespace scene {

// Whether what surfaces hide is left out.  automatic: in frames where the models' upper levels show that it
// pays, and of these not in all where it did not pay in the frames before (occlusion_choice.h).  No picture
// depends on it.  Only render::Splatter can prove what is hidden, and only of one sample a pixel: else all is
// drawn.
enum class Occlusion { automatic, on, off };

// Leaves from this size on are drawn as triangles, where they are: they are then both better and cheaper than
// splats that blend.
constexpr double kTrianglePx = 4;

struct DrawOptions {
    splat::CutOptions cut;  // triangle_px: see kTrianglePx
    render::SplatKind kind = render::SplatKind::smooth;
    render::Look look{};
    Occlusion occlusion = Occlusion::automatic;
};

// What a frame cost.
struct DrawReport {
    // Sums over the models; error_bound_px: the largest of what can be seen (of what was drawn, where a pixel
    // has several samples), infinity for squares and circles, which leave the ellipsoids.
    splat::CutCounts counts;
    uint64_t bytes_touched = 0;  // the blocks' size
    uint64_t model_blocks = 0, model_blocks_present = 0;
    double traverse_ms = 0;  // cut, and handing its splats to the painter
    double draw_ms = 0;      // set-up, drawing and shading
};

// A model in the world.
struct PlacedModel {
    const splat::Model* model;
    geom::Similarity world_from_model{};

    geom::Sphere bounds() const {
        return geom::placed({model->header().origin, model->header().scale}, world_from_model);
    }
};

struct ModelPlan {
    const splat::Model* model;
    splat::CutPlan plan;
};

// Around all of them; there is one at least.
geom::Sphere bounds_of(std::span<const PlacedModel> models);

// Spheres that hold all surfaces, some hundred for a model: those of its third level.  They stand in the
// first four kilobytes of the file, so that the first picture of one that is arriving waits for no more.
inline constexpr uint32_t kOutlineLevel = 3;
std::vector<geom::Sphere> outline_of(std::span<const PlacedModel> models);

// Draws one or more models again and again; buffers are kept from frame to frame.  Grey models among coloured
// ones are of the colour (230, 230, 230).
class ModelPainter {
  public:
    using Painter = std::unique_ptr<render::SplatPainter>;

    // The models live longer; there is one at least.  `painter`: of the back end that is to draw; not null.
    explicit ModelPainter(const std::vector<PlacedModel>& models,
                          Painter painter = std::make_unique<render::Splatter>());
    explicit ModelPainter(const splat::Model& model, Painter painter = std::make_unique<render::Splatter>())
        : ModelPainter(std::vector{PlacedModel{&model}}, std::move(painter)) {}
    // Whether the painter is one that can leave out what is hidden.
    bool can_hide() const { return prover_; }
    // Depths are in world units.
    DrawReport draw(const geom::View& view, const DrawOptions& options, render::Frame& frame);

    // What was decided for the last frame, model by model; and what a frame asks of its painter.
    std::vector<ModelPlan> plans() const;
    render::SplatterOptions splatter_options(const DrawOptions& options) const;

    // What cuts of the view would hold, as Cut::profile(), of all models together.
    splat::CutProfile profile(const geom::View& view, const splat::CutOptions& options,
                              const splat::ProfileOptions& limits) const;

    size_t size() const { return parts_.size(); }  // models
    // As of splat::Cut, of the models by their places in what the constructor was given.
    std::vector<splat::WaitingNode> waiting(size_t model) const { return parts_[model].cut->waiting(); }
    bool has_used(size_t model, uint64_t block) const { return parts_[model].cut->has_used(block); }

  private:
    struct Part {
        PlacedModel placed;
        std::unique_ptr<splat::Cut> cut;
        double scale;           // world units in a unit of the model
        size_t first_task = 0;  // of the frame's
    };

    void begin(const geom::View& view, const DrawOptions& options);
    double unit_for(const geom::View& view) const;
    bool may_have_triangles(const DrawOptions& options) const;
    // What outlining came to, of all models.
    splat::Cut::Sifted outline();
    bool finds_hidden(const geom::View& view, const DrawOptions& options);
    void walk(geom::OcclusionMap* map);
    void finish_hidden(const geom::View& view, const DrawOptions& options, render::Frame& frame);
    void repeat_unproven(const geom::View& view, const DrawOptions& options, render::Frame& frame);
    DrawReport report() const;
    // body(part, task of the part, task of the frame), in parallel.
    template <class Body>
    void for_tasks(const Body& body);

    std::vector<Part> parts_;
    double largest_ = 0;  // world units in a unit of the largest model
    double unit_ = 0;     // in one of the splats: as many, or more where the models are very far away
    bool has_colour_ = false;
    size_t task_count_ = 0;
    Painter painter_;
    render::Splatter* prover_;  // the painter, if it is one that can prove what is hidden
    geom::OcclusionMap map_;
    OcclusionChoice choice_;
    OcclusionGain gain_;
};

}  // namespace scene
