// Packets of splits, without a network: what the client has is what the server sent, and what a view wants.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "pm/client.h"
#include "pm/selection.h"
#include "streaming_link.h"

namespace {

using namespace pm_test;

pm::View random_view(Random& random, const pm::ServedModel& served) {
    const pm::Placement& placement = served.model().header().placement;
    const glm::dvec3 centre = placement.world_from_unit(glm::dvec3(0.5));
    geom::Camera camera;
    camera.eye = centre + random.direction() * placement.extent * (0.1 + 3 * random.unit());
    camera.target = centre + random.direction() * placement.extent * random.unit() * 0.7;
    camera.up = random.direction();
    camera.fovy_deg = 10 + 100 * random.unit();
    return pm::make_view(geom::make_view(camera, 320, 240), 0.2 + 8 * random.unit());
}

std::vector<mesh::Mesh> meshes() {
    return {splat_test::icosphere(3), splat_test::bumpy_torus(24, 60, true), splat_test::terrain(20),
            splat_test::mixed_scales(), crossed_sheets(20)};
}

TEST(Streaming, AllOfAModelIsTheModelFaceForFace) {
    for (const NamedMesh& shape : all_shapes())
        for (const uint32_t bits : {0u, 5u, 14u, 24u}) {
            SCOPED_TRACE(std::string(shape.name) + ", bits " + std::to_string(bits));
            pm::BuildOptions options;
            options.bits = bits;
            options.with_normals = true;
            const pm::ServedModel served(build_model(shape.mesh, options));
            StreamingLink link(served);
            link.show(pm::View(), pm::Culling::off);
            EXPECT_EQ(link.client.split_count(), served.model().details());
            link.expect_same_mesh();
            const mesh::Mesh got = pm::mesh_of(link.client, link.finest());
            EXPECT_EQ(got.colours.empty(), shape.mesh.colours.empty());
            EXPECT_EQ(got.normals.size(), got.positions.size());
        }
}

TEST(Streaming, AViewGetsWhatItWantsAndNothingTheSecondTime) {
    Random random(31);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::ServedModel served(build_model(mesh));
        pm::Selection selection(served.model());
        StreamingLink link(served);
        std::vector<pm::View> views;
        for (int i = 0; i != 25; ++i) {
            views.push_back(random_view(random, served));
            link.show(views.back());
            for (const uint32_t d : selection.select(views.back())) ASSERT_TRUE(link.record.is_sent(d));
            ASSERT_FALSE(link.lacks(views.back()));
        }
        link.expect_same_mesh();
        for (const pm::View& view : views) ASSERT_FALSE(link.lacks(view)) << "the second lap is silent";
    }
}

// What is sent one way is what the view wants, and of a whole model all of it, face for face.
TEST(Streaming, OneWayGetsTheSameSplitsInFewerBytes) {
    Random random(38);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::ServedModel served(build_model(mesh));
        pm::Selection selection(served.model());
        StreamingLink one_way(served, pm::Service::one_way), selective(served);
        for (int i = 0; i != 10; ++i) {
            const pm::View view = random_view(random, served);
            one_way.show_one_way(view, pm::Culling::on, 1 + uint32_t(random.bits() % 200));
            selective.show(view);
            for (const uint32_t d : selection.select(view)) ASSERT_TRUE(one_way.record.is_sent(d));
        }
        one_way.expect_same_mesh();
        EXPECT_LE(one_way.record.count(), selective.record.count());
        one_way.show_one_way(pm::View(), pm::Culling::off);
        selective.show(pm::View(), pm::Culling::off);
        EXPECT_EQ(one_way.record.count(), served.model().details());
        one_way.expect_same_mesh();
        EXPECT_LT(one_way.bytes, selective.bytes);
    }
}

TEST(Streaming, ListsGetWhatAViewWantsButForCones) {
    Random random(39);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::ServedModel served(build_model(mesh));
        pm::Selection selection(served.model());
        StreamingLink link(served, pm::Service::lists);
        for (int i = 0; i != 10; ++i) {
            const pm::View view = random_view(random, served);
            link.show_by_lists(view);
            for (const uint32_t d : selection.select(view)) ASSERT_TRUE(link.record.is_sent(d));
            ASSERT_EQ(link.show_by_lists(view), 0);
        }
        link.expect_same_mesh();
        link.show_by_lists(pm::View(), pm::Culling::off);
        EXPECT_EQ(link.record.count(), served.model().details());
        link.expect_same_mesh();
    }
}

bool is_closed(const pm::ServedModel& served, const pm::SentRecord& record) {
    const pm::Hierarchy tree = served.model().hierarchy();
    bool is = true;
    record.for_each([&](uint32_t d) {
        for (const uint32_t on : {tree.parent[d], tree.needs[d]})
            is = is && (on == pm::kNone || record.is_sent(on));
    });
    return is;
}

TEST(Streaming, ListsThatAskForWhatCannotBeAreErrors) {
    Random random(40);
    const pm::ServedModel served(build_model(splat_test::icosphere(3)));
    for (int i = 0; i != 100; ++i) {
        StreamingLink link(served, pm::Service::lists);
        link.show_by_lists(random_view(random, served));
        std::vector<std::byte> bytes(random.bits() % 40);
        for (std::byte& byte : bytes) byte = std::byte(random.bits());
        try {
            const std::vector<uint32_t> details = pm::read_list(served, link.record, bytes);
            pm::ListAnswer(served, link.record, details).next(pm::kMostDecisions);
        } catch (const core::Error&) {
            continue;
        }
        EXPECT_TRUE(is_closed(served, link.record));
    }
}

// The record of what was sent is enough: an answer that is given up after each packet and begun again is made
// of the same splits, each sent once.
TEST(Streaming, AnAnswerCanBeginAgainAfterAnyPacket) {
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::ServedModel served(build_model(mesh));
        StreamingLink goes_on(served), begins(served);
        pm::Selection selection(served.model());
        Random random(32);
        for (int i = 0; i != 25; ++i) {
            const pm::View view = random_view(random, served);
            goes_on.show(view);
            for (bool is_last = false; !is_last;) {
                pm::Sweep<pm::Replica> sweep = begins.sweep(view);
                const pm::Packet packet = pm::Answer(served, begins.record, view).next(50);
                pm::take_packet(begins.client, begins.models, sweep, packet.decisions, packet.check,
                                packet.bytes);
                is_last = packet.is_last;
            }
            for (const uint32_t d : selection.select(view)) ASSERT_TRUE(begins.record.is_sent(d));
        }
        for (uint32_t d = 0; d != served.model().details(); ++d)
            ASSERT_EQ(begins.record.is_sent(d), goes_on.record.is_sent(d));
        begins.expect_same_mesh();
    }
}

TEST(Streaming, TheFrontOfAViewRefinesAndCoarsensToWhatIsWanted) {
    Random random(33);
    const pm::ServedModel served(build_model(splat_test::bumpy_torus(24, 60)));
    StreamingLink link(served);
    pm::Front front(link.client.hierarchy());
    for (int i = 0; i != 30; ++i) {
        const pm::View view = random_view(random, served);
        link.show(view);
        front.grow(link.client.hierarchy());
        const pm::Sweep<pm::Replica> sweep = link.sweep(view);
        const auto is_wanted = [&](uint32_t s) { return sweep.is_wanted(link.client.node_of_split(s)); };
        for (uint32_t s = link.client.split_count(); s-- > 0;)
            if (!is_wanted(s) && front.is_split(s)) {
                ASSERT_TRUE(front.can_collapse(s));
                front.collapse(s);
            }
        for (uint32_t s = 0; s != link.client.split_count(); ++s)
            if (is_wanted(s) && !front.is_split(s)) {
                ASSERT_TRUE(front.can_split(s));
                front.split(s);
            }
        // The same details of the model make the same mesh.
        pm::Front same(served.model().hierarchy());
        const std::vector<uint32_t> detail_of = link.details_by_split();
        std::vector<uint32_t> details;
        for (uint32_t s = 0; s != link.client.split_count(); ++s)
            if (front.is_split(s)) details.push_back(detail_of[s]);
        std::sort(details.begin(), details.end());
        same.assign(details);
        ASSERT_EQ(placed(pm::mesh_of(link.client, front)), placed(pm::mesh_of(served.model(), same)));
    }
}

TEST(Streaming, ARecordTellsAnotherServerWhatWasSent) {
    Random random(34);
    for (const mesh::Mesh& mesh : meshes()) {
        const pm::ServedModel served(build_model(mesh));
        StreamingLink link(served);
        StreamingLink one_way(served, pm::Service::one_way);
        for (int i = 0; i != 10; ++i) {
            link.show(random_view(random, served));
            one_way.show_one_way(random_view(random, served));
        }
        const std::vector<std::byte> bytes = pm::encode_record(link.client);
        const pm::SentRecord record = pm::decode_record(served, bytes);
        const pm::SentRecord without_bounds =
            pm::decode_record(served, pm::encode_record(one_way.client), pm::Service::one_way);
        EXPECT_EQ(without_bounds.count(), one_way.record.count());
        EXPECT_EQ(record.count(), link.record.count());
        for (uint32_t d = 0; d != served.model().details(); ++d)
            ASSERT_EQ(record.is_sent(d), link.record.is_sent(d));
        EXPECT_EQ(record.cones.size(), link.record.cones.size());
    }
}

TEST(Streaming, AStateComesBackAsItWas) {
    Random random(35);
    for (const uint32_t bits : {0u, 14u}) {
        pm::BuildOptions options;
        options.bits = bits;
        const pm::ServedModel served(build_model(splat_test::bumpy_torus(24, 60, true), options));
        StreamingLink link(served);
        pm::ClientState state(pm::encode_header(served.model().header()),
                              {served.base_packet().begin(), served.base_packet().end()});
        for (int i = 0; i != 10; ++i) {
            const pm::View view = random_view(random, served);
            pm::Sweep sweep(state.replica(), view, state.header().placement);
            pm::Answer answer(served, link.record, view);
            const pm::Packet packet = answer.next(pm::kMostDecisions);
            pm::take_packet(state.replica(), link.models, sweep, packet.decisions, packet.check,
                            packet.bytes);
        }
        const std::vector<std::byte> bytes = state.to_bytes();
        const pm::ClientState again = pm::ClientState::from_bytes(bytes, "state");
        EXPECT_EQ(again.replica().split_count(), state.replica().split_count());
        EXPECT_EQ(again.to_bytes(), bytes);
        EXPECT_EQ(pm::encode_record(again.replica()), pm::encode_record(state.replica()));
        for (size_t size = 0; size < bytes.size(); size += 1 + size / 30) try {
                pm::ClientState::from_bytes(std::span(bytes).first(size), "state");
            } catch (const core::Error& error) {
                EXPECT_TRUE(std::string(error.what()).starts_with("state: ")) << error.what();
            }
    }
}

TEST(Streaming, DamagedOneWayPacketsAreErrorsOrMeshes) {
    Random random(41);
    const pm::ServedModel served(build_model(splat_test::icosphere(3)));
    int errors = 0;
    for (int i = 0; i != 100; ++i) {
        StreamingLink link(served, pm::Service::one_way);
        pm::PassCursor cursor(link.client);
        pm::OneWayAnswer answer(served, link.record, random_view(random, served));
        pm::Packet packet = answer.next(200);
        if (packet.bytes.empty()) continue;
        packet.bytes[random.bits() % packet.bytes.size()] ^= std::byte(1 + random.bits() % 255);
        if (i % 3 == 0) packet.bytes.resize(packet.bytes.size() / 2);
        try {
            pm::take_one_way(link.client, link.models, cursor, packet.decisions, packet.check, packet.bytes);
        } catch (const core::Error&) {
            ++errors;
        }
        link.finest();
    }
    EXPECT_GT(errors, 50);
}

// Whatever a packet says, what the client has stays a mesh.
TEST(Streaming, DamagedPacketsAreErrorsOrMeshes) {
    Random random(36);
    const pm::ServedModel served(build_model(splat_test::icosphere(3)));
    int errors = 0;
    for (int i = 0; i != 300; ++i) {
        StreamingLink link(served);
        const pm::View view = random_view(random, served);
        pm::Sweep<pm::Replica> sweep = link.sweep(view);
        pm::Answer answer(served, link.record, view);
        pm::Packet packet = answer.next(200);
        for (int flips = 0; flips != 3 && !packet.bytes.empty(); ++flips)
            packet.bytes[random.bits() % packet.bytes.size()] ^= std::byte(1 + random.bits() % 255);
        if (i % 3 == 0) packet.bytes.resize(packet.bytes.size() / 2);
        try {
            pm::take_packet(link.client, link.models, sweep, packet.decisions, packet.check, packet.bytes);
        } catch (const core::Error&) {
            ++errors;
        }
        const mesh::Mesh mesh = pm::mesh_of(link.client, link.finest());
        for (const glm::u32vec3& face : mesh.triangles)
            for (int k = 0; k != 3; ++k) ASSERT_LT(face[k], mesh.positions.size());
    }
    EXPECT_GT(errors, 200);
}

TEST(Streaming, WhatWasCutHasTheNormalsOfTheWholeSurface) {
    const mesh::Mesh input = crossed_sheets(20);
    const pm::ServedModel served(build_model(input, lossless()));
    ASSERT_GT(served.model().welds().size(), 15u);
    StreamingLink link(served);
    link.show(pm::View(), pm::Culling::off);
    EXPECT_EQ(pm::mesh_of(link.client, link.finest()).positions.size(), input.positions.size());
}

TEST(Welds, AreNumbersThatTellApartWhatMeetsByChance) {
    // 0, 2, 4 and 1, 3 are one at a place; 5, 6 elsewhere; 7 is said to be one with what is not there.
    const std::vector<pm::Weld> welds = {{4, 2}, {2, 0}, {0, 4}, {3, 1}, {5, 6}, {7, 5}};
    const pm::WeldNumbers numbers(welds, [](uint32_t v) { return glm::u32vec3(v < 5 ? 1 : v < 7 ? 2 : 3); });
    std::vector<uint32_t> as(9);
    std::iota(as.begin(), as.end(), 0u);
    std::vector<pm::WeldedVertex> shown;
    for (uint32_t v = 1; v != 8; ++v)
        shown.push_back({glm::u32vec3(v < 5 ? 1 : v < 7 ? 2 : 3), numbers[v], v});
    pm::join_welded(shown, as);
    EXPECT_EQ(as, (std::vector<uint32_t>{0, 1, 2, 1, 2, 5, 5, 7, 8})) << "0 is not shown";
    EXPECT_EQ(numbers[8], 0);
}

TEST(RangeCoder, GivesBackWhatItWasGiven) {
    Random random(37);
    for (int round = 0; round != 200; ++round) {
        struct Item {
            int kind;
            int64_t value;
        };
        std::vector<Item> items;
        // Long runs of what is likely, and of bytes of 255 to which a carry may come.
        for (int i = 0; i != 300; ++i) {
            const int kind = int(random.bits() % 4);
            const int64_t value = int64_t(random.bits() >> (random.bits() % 64));
            items.push_back({kind, kind == 0   ? random.unit() < 0.02
                                   : kind == 1 ? 65535 - int64_t(uint64_t(value) % 3)
                                   : kind == 2 ? int64_t(uint64_t(value) % 0xffffffffu)
                                               : value % 0x7fffffff});
        }
        const auto code = [&](auto& coder, auto&& each) {
            pm::BitModel bit;
            auto number = std::make_unique<pm::NumberModel<>>();
            auto signed_number = std::make_unique<pm::SignedModel<>>();
            for (const Item& item : items) {
                if (item.kind == 0) each(item, coder.bit(bit, item.value != 0));
                if (item.kind == 1) each(item, coder.uniform(65536, uint32_t(item.value)));
                if (item.kind == 2) each(item, pm::code_number(coder, *number, uint32_t(item.value)));
                if (item.kind == 3) each(item, pm::code_signed(coder, *signed_number, item.value));
            }
        };
        pm::RangeEncoder encoder;
        code(encoder, [](const Item&, int64_t) {});
        const std::vector<std::byte> bytes = encoder.finish();
        pm::RangeDecoder decoder(bytes);
        code(decoder, [](const Item& item, int64_t value) { ASSERT_EQ(value, item.value); });
        EXPECT_FALSE(decoder.is_beyond_end());
    }
}

TEST(RingMesh, RefusesWhatHasNoRings) {
    using Corners = std::vector<glm::u32vec3>;
    EXPECT_THROW(pm::RingMesh(3, Corners{{0, 1, 3}}), core::Error);
    EXPECT_THROW(pm::RingMesh(3, Corners{{0, 1, 1}}), core::Error);
    EXPECT_THROW(pm::RingMesh(4, Corners{{0, 1, 2}, {0, 1, 3}}), core::Error) << "two of one orientation";
    EXPECT_THROW(pm::RingMesh(5, Corners{{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}), core::Error)
        << "three at an edge";
    EXPECT_THROW(pm::RingMesh(5, Corners{{0, 1, 2}, {0, 3, 4}}), core::Error) << "two rings";
    EXPECT_NO_THROW(pm::RingMesh(4, Corners{{0, 1, 2}, {1, 0, 3}}));
}

}  // namespace
