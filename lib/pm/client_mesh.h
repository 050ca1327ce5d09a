// The mesh that a client shows.
#pragma once

#include <string>

#include "mesh/mesh.h"
#include "net/address.h"
#include "pm/front.h"
#include "pm/replica.h"

namespace pm {

// The mesh of a front of what was received, in world units: as mesh_of() of a model (extract.h).
mesh::Mesh mesh_of(const Replica& replica, const Front& front);

// "pm://HOST:PORT/NAME", or "pm:///PATH/OF/SOCKET/NAME" for a Unix socket; NAME may be empty where the server
// has one model.
struct Location {
    net::Address address;
    std::string name;
};
bool is_location(const std::string& text);  // by its beginning alone
// Throws core::UsageError.
Location parse_location(const std::string& text);

}  // namespace pm
