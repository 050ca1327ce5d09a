// What is hidden in a picture, by blocks of pixels: first guessed, then proved.
//
// A walk shows the map the surface that it is about to draw, coarsely: add_surfaces(), build().  Then it
// leaves out what look() takes for hidden.  That is a guess: the surface may have holes that only its details
// show.  So the map notes how near to the eye what was left out may come, limit(), and whoever draws holds
// every pixel against that and marks the blocks where what was drawn does not stand clear of it,
// mark_unproven().  After begin_repeat() look() passes what reaches into such blocks, all of it, and nothing
// else.
//
// Pixels are those of the picture, of which the view may be a part.  Positions are in view space as in
// camera.h, in the unit of the splats; depths are compared as their inverses, which are linear in the
// picture.
//
// Greene, Kass, Miller.  Hierarchical Z-buffer visibility.  1993.  There the pyramid is of what was drawn,
// and needs no proof; here it is made before anything is drawn, so that the order of drawing is left alone.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "geom/camera.h"

namespace geom {

class OcclusionMap {
  public:
    static constexpr int kBlock = 16;  // pixels across

    OcclusionMap();
    ~OcclusionMap();

    // Starts a frame.  `unit`: world units in a unit of the splats.  Takes about 12 bytes a block, and 4 more
    // for each thread that adds surfaces.
    void begin(const View& view, double unit);

    // A disc that stands for a piece of the surface, which keeps to within `thickness` of it.
    struct Surface {
        glm::vec3 centre;
        float radius;
        glm::vec3 normal;
        float thickness;
    };
    // From any thread; the order does not count.
    void add_surfaces(std::span<const Surface> surfaces);

    // Call after the last surface.
    void build();

    // Some spheres, by their coordinates.
    struct Spheres {
        static constexpr size_t kCapacity = 128;
        size_t count = 0;
        alignas(64) float x[kCapacity]{}, y[kCapacity]{}, z[kCapacity]{}, radius[kCapacity]{};

        void add(const glm::vec3& centre, float r) {
            x[count] = centre.x, y[count] = centre.y, z[count] = centre.z, radius[count++] = r;
        }
    };
    // hidden: nothing in the sphere need be drawn, which the map has noted.  partly: parts of it may be
    // hidden.  clear: hardly, or they are too small to be worth a look.
    enum class Sight { hidden, partly, clear };
    // Finds the sight of each sphere.  From any thread; the order does not count.  Nothing within four radii
    // of the eye's plane is hidden.
    void look(const Spheres& spheres, Sight* sights);

    // Whether anything was hidden so far.
    bool has_hidden() const;

    // In the block of pixel (x, y): no fragment of what is hidden there has an inverse depth, or one plus
    // its radius's worth of inverse depth, above this; 0 where nothing is hidden.
    float limit(int x, int y) const;

    // The block of pixel (x, y).  Different blocks from any threads.
    void mark_unproven(int x, int y);
    bool is_unproven(int x, int y) const;
    bool has_unproven() const;

    void begin_repeat();
    bool is_repeated() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace geom
