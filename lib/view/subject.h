// What is looked at: a source that draws itself, a picture after the other, each better than the one before
// while nothing is changed.
//
// Its calls are those of one thread, which they may keep as long as a frame takes; none waits for a network.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geom/sphere.h"
#include "scene/backends.h"
#include "scene/sources.h"
#include "view/picture.h"

namespace view {

class Subject {
  public:
    virtual ~Subject() = default;

    virtual geom::Sphere bounds() const = 0;                // world units
    virtual std::vector<geom::Sphere> outline() const = 0;  // spheres that hold it all
    virtual std::string describe() const = 0;               // what draws, and what it draws; for people

    // The next picture: the first of a wish that shows something else is drawn in its budget, those after it
    // as fine as the wish asks for in the end, in steps.  Throws core::Error where nothing can be drawn any
    // more.
    virtual PictureReport draw(const Wish& wish, render::Frame& frame) = 0;
    // A view of the same, as fine as the wish asks for, of what is there.
    virtual void draw_part(const geom::View& view, const Wish& wish, render::Frame& frame) = 0;
    // Whether draw() of the same wish would show more than the last one did.
    virtual bool has_more(const Wish& wish) = 0;
    // Whether it may have more later without anybody wishing anything.
    virtual bool is_arriving() const = 0;
};

struct SubjectOptions {
    scene::BackendKind backend = scene::BackendKind::automatic;
    render::SplatKind splat = render::SplatKind::smooth;
    std::string cache{};  // folder of qs-fetch's cache; empty: its default
    int width = 1280, height = 720;
};

// Opens what is named as for qs-render, and meshes, which are first made into models.  Waits for disks and
// networks.  Throws core::Error, core::UsageError.
std::unique_ptr<Subject> open_subject(const std::vector<std::string>& sources, const SubjectOptions& options);

// Those of each kind.
std::unique_ptr<Subject> open_splats(const std::vector<scene::Source>& sources,
                                     const SubjectOptions& options);
std::unique_ptr<Subject> open_progressive_mesh(const std::string& source, const SubjectOptions& options);
std::unique_ptr<Subject> open_points(const std::string& source, const SubjectOptions& options);

}  // namespace view
