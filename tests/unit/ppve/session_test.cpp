#include "ppve/session.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "ppve/sample/raster_sampler.h"
#include "scenes.h"

namespace {

using namespace ppve;

// What a client does with answers: keeps its octree as it is told.
struct Mirror {
    explicit Mirror(const Welcome& welcome) : tree(shape_around(welcome.bounds)) {}

    // False where the octree is not what the server says.
    bool take(const Answer& a) {
        const DepthImage image = image_of(a);
        Change change;
        change.starts_anew = a.starts_anew, change.obsolete = a.deleted;
        if (!a.replaced.empty()) change.removed = read_removals(a.replaced, tree.points());
        change.update = a.id, change.added = &image;
        tree.apply(change);
        last = a.id;
        return tree.checksum() == a.octree_checksum;
    }

    Octree tree;
    uint64_t last = 0;
};

struct Scene {
    RasterSampler sampler{Clusters(ppve_test::ball(80, 1))};
    uint64_t next_id = 0;

    Request request(const glm::dvec3& eye, const Mirror* mirror = nullptr) {
        Request r;
        r.id = ++next_id;
        r.frustum = ppve_test::looking_from(eye, {0, 0, 0}, 96, 64);
        if (mirror != nullptr) r.last_answer = mirror->last, r.octree_checksum = mirror->tree.checksum();
        return r;
    }
};

Answer answer_of(Session& session, const Request& request, AnswerReport* into = nullptr) {
    EXPECT_TRUE(session.take(request).empty());
    AnswerReport report;
    const Message message = parse(session.answer(report), "server");
    if (into != nullptr) *into = report;
    return std::get<Answer>(message);
}

glm::dvec3 random_eye(std::mt19937_64& random) {
    const double away = ppve_test::uniform(random, 1.2, 5);
    return away *
           glm::normalize(glm::dvec3(ppve_test::uniform(random, -1, 1), ppve_test::uniform(random, -1, 1),
                                     ppve_test::uniform(random, -1, 1)));
}

// Long random sessions: views of all kinds, deletions of leaves that are there and of ones that are not,
// normals now and then, the paper's rule and ours, a small memory.
TEST(Session, BothSidesHoldTheSameOctreeAfterEveryMessage) {
    Scene scene;
    for (const uint64_t seed : {1, 2, 3}) {
        std::mt19937_64 random(seed);
        scene.next_id = 0;
        Session session(scene.sampler, "ball", {.most_points = 30'000});
        Mirror mirror(session.welcome());
        uint64_t evicted = 0, replaced = 0;
        for (int n = 0; n < 60; ++n) {
            Request r = scene.request(random_eye(random), &mirror);
            r.elimination = Elimination(random() % 3), r.epsilon = 0.01;
            r.footprint_px = random() % 4 == 0 ? 0.5 : 1;
            r.wants_normals = random() % 2 == 0;
            r.codec = Codec(random() % 2);
            if (random() % 3 == 0)
                mirror.tree.for_each([&](const Cluster& c) {
                    if (random() % 5 == 0) r.deletions.push_back(c.id);
                });
            r.deletions.push_back(random());
            AnswerReport report;
            const Answer a = answer_of(session, r, &report);
            ASSERT_FALSE(a.starts_anew);
            ASSERT_TRUE(mirror.take(a)) << seed << ", answer " << n;
            ASSERT_EQ(mirror.tree.checksum(), session.tree().checksum());
            ASSERT_LE(session.tree().points(), 30'000u);
            evicted += report.evicted, replaced += report.elimination.removed;
        }
        EXPECT_GT(evicted, 0u);
        EXPECT_GT(replaced, 0u);
    }
}

// The bench has ten thousand (point_view_bench --what session).
TEST(Session, KeepsToItsPointsForAThousandUpdates) {
    Scene scene;
    Session session(scene.sampler, "ball", {.most_pixels = 1 << 20, .most_points = 5000});
    Mirror mirror(session.welcome());
    std::mt19937_64 random(5);
    uint64_t most = 0, evicted = 0;
    for (int k = 0; k < 1000; ++k) {
        Request request = scene.request(random_eye(random), &mirror);
        request.frustum = ppve_test::looking_from(random_eye(random), {0, 0, 0}, 32, 24);
        AnswerReport report;
        ASSERT_TRUE(mirror.take(answer_of(session, request, &report))) << k;
        most = std::max(most, session.tree().points());
        evicted += report.evicted;
    }
    EXPECT_LE(most, 5000u);
    EXPECT_GT(evicted, 20u);
}

TEST(Session, SendsASecondViewOfTheSameAlmostForNothing) {
    Scene scene;
    Session session(scene.sampler, "ball", {});
    Mirror mirror(session.welcome());
    AnswerReport first, second;
    mirror.take(answer_of(session, scene.request({0, 0, 3}, &mirror), &first));
    mirror.take(answer_of(session, scene.request({0, 0, 3}, &mirror), &second));
    EXPECT_EQ(first.elimination.kept, first.elimination.samples);
    EXPECT_LT(double(second.elimination.kept), 0.02 * double(second.elimination.samples));
}

TEST(Session, AClientOutOfStepIsStartedAnewAndIsInStepAgain) {
    Scene scene;
    Session session(scene.sampler, "ball", {});
    Mirror mirror(session.welcome());
    ASSERT_TRUE(mirror.take(answer_of(session, scene.request({0, 0, 3}, &mirror))));
    Request r = scene.request({0, 1, 3}, &mirror);
    r.octree_checksum ^= 1;
    const Answer a = answer_of(session, r);
    EXPECT_TRUE(a.starts_anew);
    ASSERT_TRUE(mirror.take(a));
    // Requests that were on their way then name what was before; that is no new fault.
    Request late = scene.request({0, 1, 3});
    late.last_answer = 1, late.octree_checksum = 12345;
    const Answer b = answer_of(session, late);
    EXPECT_FALSE(b.starts_anew);
    EXPECT_TRUE(mirror.take(b));
    // An answer that never was.
    Request odd = scene.request({0, 1, 3});
    odd.last_answer = 1000, odd.octree_checksum = 0;
    EXPECT_TRUE(answer_of(session, odd).starts_anew);
}

TEST(Session, ANewerRequestTakesThePlaceOfOneThatWaits) {
    Scene scene;
    Session session(scene.sampler, "ball", {});
    EXPECT_TRUE(session.take(scene.request({0, 0, 3})).empty());
    const auto refusals = session.take(scene.request({0, 3, 1}));
    ASSERT_EQ(refusals.size(), 1u);
    EXPECT_EQ(refusals[0].id, 1u);
    AnswerReport report;
    EXPECT_EQ(std::get<Answer>(parse(session.answer(report), "server")).id, 2u);
    EXPECT_FALSE(session.has_request());
}

TEST(Session, RefusesWhatIsTooLargeOrNotCountedUp) {
    Scene scene;
    Session session(scene.sampler, "ball", {.most_pixels = 1000});
    EXPECT_EQ(session.take(scene.request({0, 0, 3})).size(), 1u);
    EXPECT_FALSE(session.has_request());
    Request old = scene.request({0, 0, 3});
    old.id = 1, old.frustum.view.width = 8, old.frustum.view.height = 8;
    EXPECT_EQ(session.take(old).size(), 1u);
    EXPECT_THROW(session.take(Refusal{1, "what a server says"}), core::Error);
}

// Everything that a request may be, at its ends.
TEST(Session, AnswersAnyFrustumThatIsOne) {
    Scene scene;
    Session session(scene.sampler, "ball", {});
    Mirror mirror(session.welcome());
    const auto asked = [&](const auto& change) {
        Request r = scene.request({0, 0.3, 3}, &mirror);
        change(r);
        ASSERT_TRUE(mirror.take(answer_of(session, r)));
    };
    asked([](Request& r) { r.frustum.view.width = r.frustum.view.height = 1; });
    asked([](Request& r) { r.frustum.view.eye = {0, 0, 0}; });  // inside
    asked([](Request& r) { r.frustum.view.near = 1e-6, r.frustum.view.far = 1e9; });
    asked([](Request& r) { r.frustum.view.near = 10, r.frustum.view.far = 11; });  // nothing there
    asked([](Request& r) { r.frustum.view.focal_px = 1e16; });                     // extremely narrow
    asked([](Request& r) { r.frustum.view.focal_px = 1e-6; });                     // extremely wide
    asked([](Request& r) { r.frustum.view.right = -r.frustum.view.right; });       // mirrored
    asked([](Request& r) { r.frustum.projection = Projection::orthographic; });
    asked([](Request& r) {
        r.frustum.projection = Projection::orthographic, r.frustum.view.eye = {0, 0, -1e12};
    });
    asked([](Request& r) { r.frustum.view.eye = {1e90, 0, 0}; });
    asked([](Request& r) { r.frustum.view.shift_px = {1e14, 1e14}; });
    asked([](Request& r) { r.bound_px = 1e6; });
    asked([](Request& r) { r.bound_px = 1e-300; });
}

}  // namespace
