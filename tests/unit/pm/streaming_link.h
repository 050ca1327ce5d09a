// A server's and a client's side of one model without a network between them.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "pm/answer.h"
#include "pm/client_mesh.h"
#include "pm/extract.h"
#include "test_models.h"

namespace pm_test {

struct StreamingLink {
    const pm::ServedModel& served;
    pm::SentRecord record;
    std::unique_ptr<pm::ServedReplica> server;
    pm::BaseMesh base;
    pm::Replica client;
    pm::SplitModels models;
    std::vector<std::byte> last_packet;
    size_t bytes = 0;

    explicit StreamingLink(const pm::ServedModel& model)
        : served(model),
          server(std::make_unique<pm::ServedReplica>(model, record)),
          base(pm::decode_base(model.model().header(), model.base_packet())),
          client(model.model().header(), base.vertices, base.faces, base.nodes) {}

    bool lacks(const pm::View& view, pm::Culling culling = pm::Culling::on) const {
        return pm::Sweep(client, view, culling).current() != pm::kNone;
    }
    // The server forgets what it can build anew.
    void forget() { server = std::make_unique<pm::ServedReplica>(served, record); }

    pm::AnswerCounts show(const pm::View& view, pm::Culling culling = pm::Culling::on,
                          uint32_t packet = 100) {
        pm::Sweep sweep(client, view, culling);
        pm::Answer answer(served, record, *server, view, culling);
        for (;;) {
            const pm::Answer::Packet next = answer.next(packet);
            bytes += next.bytes.size();
            last_packet = next.bytes;
            pm::take_packet(client, models, sweep, next.decisions, next.check, next.bytes);
            if (next.is_last) break;
        }
        EXPECT_EQ(sweep.current(), pm::kNone);
        return answer.counts();
    }

    pm::Front finest() const {
        pm::Front front(client.hierarchy());
        for (uint32_t s = 0; s != client.split_count(); ++s) {
            EXPECT_TRUE(front.can_split(s));
            front.split(s);
        }
        return front;
    }
    // The model's front of what was sent.
    pm::Front sent() const {
        pm::Front front(served.model().hierarchy());
        for (uint32_t d = 0; d != served.model().details(); ++d)
            if (record.is_sent(d)) front.split(d);
        return front;
    }
    void expect_same_mesh() const {
        pm::Front front = sent();
        EXPECT_EQ(client.split_count(), front.split_count());
        EXPECT_EQ(placed(pm::mesh_of(client, finest())), placed(pm::mesh_of(served.model(), front)));
    }
};

}  // namespace pm_test
