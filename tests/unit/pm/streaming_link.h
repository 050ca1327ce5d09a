// A server's and a client's side of one model without a network between them.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "pm/answer.h"
#include "pm/client_mesh.h"
#include "pm/extract.h"
#include "pm/lists.h"
#include "pm/messages.h"
#include "pm/one_way.h"
#include "test_models.h"

namespace pm_test {

struct StreamingLink {
    const pm::ServedModel& served;
    pm::SentRecord record;
    pm::BaseMesh base;
    pm::Replica client;
    pm::SplitModels models;
    std::vector<std::byte> last_packet;
    size_t bytes = 0;

    explicit StreamingLink(const pm::ServedModel& model, pm::Service service = pm::Service::selective)
        : served(model),
          record(service),
          base(pm::decode_base(model.model().header(), model.base_packet(service), tells_bounds(service))),
          client(model.model().header(), base.vertices, base.faces, base.nodes) {}

    bool lacks(const pm::View& view, pm::Culling culling = pm::Culling::on) const {
        return sweep(view, culling).current() != pm::kNone;
    }
    pm::Sweep<pm::Replica> sweep(const pm::View& view, pm::Culling culling = pm::Culling::on) const {
        return pm::Sweep(client, view, client.header().placement, culling);
    }

    pm::AnswerCounts show(const pm::View& view, pm::Culling culling = pm::Culling::on,
                          uint32_t packet = 100) {
        pm::Sweep<pm::Replica> sweep = this->sweep(view, culling);
        pm::Answer answer(served, record, view, culling);
        for (;;) {
            const pm::Packet next = answer.next(packet);
            bytes += next.bytes.size();
            last_packet = next.bytes;
            pm::take_packet(client, models, sweep, next.decisions, next.check, next.bytes);
            if (next.is_last) break;
        }
        EXPECT_EQ(sweep.current(), pm::kNone);
        return answer.counts();
    }

    // One way.
    void show_one_way(const pm::View& view, pm::Culling culling = pm::Culling::on, uint32_t packet = 100) {
        pm::PassCursor cursor(client);
        pm::OneWayAnswer answer(served, record, view, culling);
        for (bool is_last = false; !is_last;) {
            const pm::Packet next = answer.next(packet);
            bytes += next.bytes.size();
            pm::take_one_way(client, models, cursor, next.decisions, next.check, next.bytes);
            is_last = next.is_last;
        }
    }
    // By lists, each of so many nodes at most; the number of lists.
    int show_by_lists(const pm::View& view, pm::Culling culling = pm::Culling::on, size_t most = 300) {
        for (int lists = 0;; ++lists) {
            pm::Sweep<pm::Replica> sweep = this->sweep(view, culling);
            if (sweep.current() == pm::kNone) return lists;
            const pm::NodeList list = pm::make_list(client, models, sweep, most);
            const std::vector<uint32_t> details = pm::read_list(served, record, list.bytes);
            EXPECT_EQ(details.size(), list.nodes.size());
            pm::ListAnswer answer(served, record, details);
            const pm::Packet next = answer.next(pm::kMostDecisions);
            EXPECT_TRUE(next.is_last);
            bytes += next.bytes.size();
            pm::take_list_packet(client, models, list.nodes, next.check, next.bytes);
        }
    }

    // By the client's split: the detail that it is in the model.
    std::vector<uint32_t> details_by_split() const {
        std::vector<uint32_t> detail_of(client.nodes().size(), pm::kNone), details;
        for (uint32_t root = 0; root != served.base_order().size(); ++root)
            detail_of[root] = served.model().root_split()[served.base_order()[root]];
        for (uint32_t s = 0; s != client.split_count(); ++s) {
            const uint32_t node = client.node_of_split(s), detail = detail_of[node];
            details.push_back(detail);
            const auto [kept, fresh] = client.children(node);
            detail_of[kept] = served.model().children()[detail].kept;
            detail_of[fresh] = served.model().children()[detail].fresh;
        }
        return details;
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
        const mesh::Mesh got = pm::mesh_of(client, finest()), given = pm::mesh_of(served.model(), front);
        EXPECT_EQ(placed(got), placed(given));
        EXPECT_EQ(got.positions.size(), given.positions.size()) << "what was cut is one again";
    }
};

}  // namespace pm_test
