// Any header: fields that hold what they promise.  Nothing else.
#include <cstdint>
#include <string_view>

#include "fetch/http_fields.h"
#include "require.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    std::string_view text(reinterpret_cast<const char*>(data), size);
    fetch::HttpFields fields;
    while (!text.empty()) {
        const size_t end = text.find('\n');
        fields.take_line(text.substr(0, end), 1'700'000'000);
        text = end == std::string_view::npos ? "" : text.substr(end + 1);
    }
    require(fields.status >= 0 && fields.status <= 999, "a status has three digits");
    if (const auto& range = fields.content_range; range && range->has_bytes)
        require(range->first <= range->last && range->last < range->total, "a range is within its file");
    if (fields.retry_after_s)
        require(*fields.retry_after_s >= 0 && *fields.retry_after_s <= fetch::kMostRetrySeconds,
                "a wait is bounded");
    for (const std::string& validator : {fields.validator.etag, fields.validator.last_modified})
        for (const char c : validator) require(c >= ' ' && c <= '~', "a validator can be sent back");
    return 0;
}
