// Any bytes: a request or a reply that writes the same bytes again, or Error.  Nothing else.
#include <algorithm>
#include <cstdint>

#include "core/error.h"
#include "fetch/messages.h"
#include "require.h"

namespace {

template <class Parse>
void check(std::span<const std::byte> bytes, const Parse& parse) {
    try {
        const auto message = parse(bytes);
        const auto again = fetch::to_bytes(message);
        // Any number but 0 is taken for a right answer.
        if constexpr (requires { message.is_right; })
            if (message.is_right) return;
        require(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()),
                "a message writes its bytes again");
    } catch (const core::Error&) {
        // rejecting is fine
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto bytes = std::as_bytes(std::span(data, size));
    check(bytes, fetch::parse_request);
    check(bytes, fetch::parse_reply);
    return 0;
}
