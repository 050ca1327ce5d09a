// Runs of triangles as a sequence of symbols, from any of their steps on: the model of compressed blocks of
// triangles, the same code for taking plain runs apart, counting, encoding and decoding.  man/qs.5 specifies
// it.
//
// What pays: which edge a triangle is glued to, mostly one of the one before; how far back an entry stands
// that was had; and the high bits of differences, by how wide the widest of the corner is.  Differences have
// few more low bits than noise has, and those stay as they are.
//
// Included once for each SIMD target, by sources that use Highway's foreach_target.h.
#if defined(QS_SPLAT_RUN_SYMBOLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QS_SPLAT_RUN_SYMBOLS_INL_H
#undef QS_SPLAT_RUN_SYMBOLS_INL_H
#else
#define QS_SPLAT_RUN_SYMBOLS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>

#include "splat/coding/glue_code.h"
#include "splat/coding/run_codec.h"

HWY_BEFORE_NAMESPACE();
namespace splat {
namespace HWY_NAMESPACE {

// How far back an entry stands that was had: by symbol, the nearest of so many, of which one is told by
// `bits`. Symbol 0 is a new entry.
struct EntriesBack {
    uint32_t first = 0, bits = 0;
};
constexpr uint32_t kEntrySymbols = kSymbolFields[kEntry].symbols;
constexpr std::array<EntriesBack, kEntrySymbols> kEntriesBack = [] {
    std::array<EntriesBack, kEntrySymbols> backs{};
    for (uint32_t s = 2; s < kEntrySymbols; ++s) {
        const EntriesBack& before = backs[s - 1];
        backs[s] = {before.first + (1u << before.bits), s < 9 ? 0 : (s - 9) / 2 + 2};
    }
    return backs;
}();
constexpr uint32_t SymbolOfBack(uint32_t back) {
    if (back < 8) return 1 + back;
    const auto octave = uint32_t(std::bit_width(back)) - 4;
    return 9 + 2 * octave + (back >> (octave + 2) & 1);
}

// To which triangle and edge one is glued: 0 to none; to one of the last nine, edge by edge; to one further
// back.
constexpr uint32_t kNearTriangles = 9, kFarGlue = 3 * kNearTriangles + 1;
constexpr uint32_t SymbolOfGlue(uint32_t back, uint32_t edge) {
    return back <= kNearTriangles ? 3 * back + edge - 2 : kFarGlue + edge;
}
struct GlueBits {
    uint32_t value = 0, width = 0;
};
constexpr GlueBits BitsOfGlue(uint32_t back, uint32_t edge) {
    const auto zeros = uint32_t(std::bit_width(back)) - 1;
    const uint32_t low = back & ((1u << zeros) - 1);
    return {1u | 2u << zeros | low << (zeros + 2) | (edge == 2 ? 3u : edge) << (2 * zeros + 2),
            2 * zeros + (edge == 0 ? 3 : 4)};
}
constexpr std::array<GlueBits, kFarGlue> kNearGlueBits = [] {
    std::array<GlueBits, kFarGlue> bits{};
    for (uint32_t s = 1; s < kFarGlue; ++s) bits[s] = BitsOfGlue((s + 2) / 3, (s + 2) % 3);
    return bits;
}();

// A row has the bits of plain runs: peek(), the next 57 of them, and peek_behind() others, or 0 where they
// are not known; put(value, width), width <= 56, writes them where they are not, and goes on by so many; at()
// is the next one's place; and begin() stands before what is at most 128 bits.
template <class Coder, class Row>
class RunSteps {
  public:
    HWY_INLINE RunSteps(Coder& coder, Row& row, uint32_t lattice_bits)
        : coder_(coder), row_(row), lattice_bits_(lattice_bits) {}

    // What a decoder is told of `place`.
    HWY_INLINE bool take_place(RunPlace& place) {
        if (!begin()) return false;
        const auto take = [&](uint32_t bits, uint32_t value)
                              HWY_ATTR { return uint32_t(coder_.template plain<kGlue>(bits, value)); };
        place.part = take(3, place.part), place.cut = take(7, place.cut);
        if (place.part == RunPlace::head) return true;
        if (place.part >= RunPlace::lost || !begin()) return false;
        place.triangle_count = take(kRunTriangleBits, place.triangle_count - 1) + 1;
        place.corner_count = take(kRunCornerBits, place.corner_count - 1) + 1;
        place.shading_kind = take(kRunShadingBits, place.shading_kind);
        place.position_width = take(kPositionWidthBits, place.position_width);
        place.normal_width = take(kNormalWidthBits, place.normal_width);
        place.left = take(kRunCornerBits, place.left - 1) + 1;
        if (place.part == RunPlace::triangles) place.had = take(kRunCornerBits, place.had);
        return true;
    }

    // Whole steps from `place` on, until `end` or past it.  False where there is no more input, or no run.
    HWY_INLINE bool take_steps(RunPlace& place, uint64_t end) {
        while (row_.at() < end) {
            bool is_run = false;
            switch (place.part) {
                case RunPlace::head:
                    is_run = begin() && take_head(place);
                    break;
                case RunPlace::triangles:
                    is_run = repeat<&RunSteps::take_triangle>(place, end);
                    break;
                case RunPlace::positions:
                    is_run = repeat<&RunSteps::take_position>(place, end);
                    break;
                case RunPlace::normals:
                    is_run = repeat<&RunSteps::take_normal>(place, end);
                    break;
                case RunPlace::shading:
                    is_run = repeat<&RunSteps::take_shading>(place, end);
                    break;
                default:
                    break;
            }
            if (!is_run) return false;
            if (place.left == 0) begin_next_part(place);
        }
        return true;
    }

    // Bits whose step is not known, or not worth it.
    template <SymbolKind kKind>
    HWY_INLINE bool as_they_are(uint32_t count) {
        constexpr uint32_t kMost = 24;
        for (; count > kMost; count -= kMost) {
            as_it_is<kKind>(kMost);
            if (!begin()) return false;
        }
        as_it_is<kKind>(count);
        return begin();
    }

  private:
    enum Lane { kFirstLane, kSecondLane, kThirdLane, kClassLane };

    HWY_INLINE bool begin() { return coder_.begin() && row_.begin(); }

    template <auto kStep>
    HWY_INLINE bool repeat(RunPlace& place, uint64_t end) {
        for (; place.left > 0 && row_.at() < end; --place.left)
            if (!begin() || !(this->*kStep)(place)) return false;
        return true;
    }

    template <SymbolKind kKind>
    HWY_INLINE uint32_t as_it_is(uint32_t width) {
        const uint32_t known = uint32_t(row_.peek()) & ((1u << width) - 1);
        const uint32_t value = uint32_t(coder_.template plain<kKind>(width, known));
        row_.put(value, width);
        return value;
    }

    HWY_INLINE bool take_head(RunPlace& place) {
        // What fills the last byte of the run before.
        as_it_is<kGlue>(uint32_t(-row_.at() & 7));
        as_it_is<kGlue>(kRunSizeBits);
        place.triangle_count = as_it_is<kGlue>(kRunTriangleBits) + 1;
        place.corner_count = as_it_is<kGlue>(kRunCornerBits) + 1;
        place.shading_kind = as_it_is<kGlue>(kRunShadingBits);
        place.position_width = as_it_is<kGlue>(kPositionWidthBits);
        place.normal_width = as_it_is<kGlue>(kNormalWidthBits);
        return true;
    }

    HWY_INLINE void begin_next_part(RunPlace& place) {
        const auto begin_part = [&](RunPlace::Part part, uint32_t steps) {
            place.part = part, place.left = steps;
        };
        if (place.part == RunPlace::head)
            begin_part(RunPlace::triangles, place.triangle_count), place.had = 0;
        else if (place.part == RunPlace::triangles)
            begin_part(RunPlace::positions, place.corner_count);
        else if (place.part == RunPlace::positions && place.shading_kind != uint32_t(RunShading::flat))
            begin_part(RunPlace::normals, place.corner_count);
        else if (place.part == RunPlace::normals && place.shading_kind == uint32_t(RunShading::mixed))
            begin_part(RunPlace::shading, place.triangle_count);
        else
            begin_part(RunPlace::head, 0);
    }

    HWY_INLINE bool take_triangle(RunPlace& place) {
        uint32_t symbol = 0, back = 0;
        if (Row::kIsKnown && (row_.peek() & 1) != 0) {
            const GlueCode glue = long_glue_code(row_.peek() >> 1);
            if (glue.back >= kMostRunTriangles) return false;
            symbol = SymbolOfGlue(glue.back, glue.edge), back = glue.back;
        }
        symbol = coder_.template code<kFirstLane, kGlue>(last_is_new_, symbol);
        if (HWY_UNLIKELY(symbol == 0)) {
            take_corner(place, {0, 1}, 1);
            for (int k = 1; k < 3; ++k) {
                if (!begin()) return false;
                take_corner(place, {}, 1);
            }
            return true;
        }
        GlueBits bits = kNearGlueBits[symbol % kFarGlue];
        if (HWY_UNLIKELY(symbol >= kFarGlue)) {
            back = uint32_t(coder_.template plain<kGlue>(kRunTriangleBits, back));
            bits = BitsOfGlue(std::max(back, 1u), symbol - kFarGlue);
        }
        take_corner(place, bits, symbol > 3);
        return true;
    }

    // Behind the bits that say to what its triangle is glued.  Without branches: whether it is new is
    // anyone's guess.
    HWY_INLINE void take_corner(RunPlace& place, const GlueBits& glue, uint32_t context) {
        const uint32_t last = std::max(place.had, 1u) - 1;
        const uint32_t width = uint32_t(std::bit_width(last)), mask = (1u << width) - 1;
        uint32_t symbol = 0, back = 0;
        if (const uint64_t known = row_.peek() >> glue.width; Row::kIsKnown && (known & 1) == 0) {
            back = (last - uint32_t(known >> 1)) & mask;
            symbol = SymbolOfBack(back);
        }
        symbol = coder_.template code<kSecondLane, kEntry>(context, symbol);
        const EntriesBack backs = kEntriesBack[symbol];
        back = backs.first + uint32_t(coder_.template plain<kEntry>(backs.bits, back - backs.first));
        const uint32_t is_new = symbol == 0, is_had = is_new - 1;  // a mask
        const uint32_t corner = is_new | (((last - back) & mask) << 1 & is_had);
        row_.put(glue.value | corner << glue.width, glue.width + 1 + (width & is_had));
        place.had += is_new, last_is_new_ = is_new;
    }

    // Differences of so many bits, of which the highest five, or fewer, are symbols.
    struct Width {
        explicit Width(uint32_t bits) : all(bits), low(std::max(bits, 5u) - 5) {}
        uint32_t all, low;
        uint64_t low_of(uint64_t value) const { return value & ((uint64_t(1) << low) - 1); }
        uint32_t high_of(uint64_t value) const {
            return uint32_t((value & ((uint64_t(1) << all) - 1)) >> low);
        }
        uint64_t joined(uint32_t high, uint64_t rest) const { return uint64_t(high) << low | low_of(rest); }
    };

    // One that would not have gone into the next smaller class.
    static uint32_t is_wide(uint32_t high) { return ((high + 4) >> 3 & 3) != 0; }

    HWY_INLINE bool take_position(RunPlace& place) {
        const uint64_t known = row_.peek();
        const uint32_t size_class =
            coder_.template code<kClassLane, kPositionClass>(last_position_class_, uint32_t(known) & 3);
        last_position_class_ = size_class;
        const Width width(position_width(place.position_width, size_class, lattice_bits_));
        if (HWY_UNLIKELY(size_class == 3 || width.all > kWidest)) {
            row_.put(size_class, kClassBits);
            return begin() && as_they_are<kPosition>(3 * width.all);
        }
        const uint64_t known_x = known >> kClassBits, known_y = known_x >> width.all,
                       known_z = row_.peek_behind(kClassBits + 2 * width.all);
        // A class says that one at least is wide; in class 0 that means nothing.
        constexpr uint32_t kLast = 3, kAfterWide = 4;
        const uint32_t narrow = size_class, some = size_class == 0 ? 0 : kAfterWide,
                       none = size_class == 0 ? 0 : kLast;
        const uint32_t x = coder_.template code<kFirstLane, kPosition>(narrow, width.high_of(known_x));
        uint32_t wide = is_wide(x);
        const uint32_t y =
            coder_.template code<kSecondLane, kPosition>(wide ? some : narrow, width.high_of(known_y));
        wide |= is_wide(y);
        const uint32_t z =
            coder_.template code<kThirdLane, kPosition>(wide ? some : none, width.high_of(known_z));
        const bool are_many = width.low > 8;  // more low bits than are there behind three symbols
        if (HWY_UNLIKELY(are_many) && !coder_.begin()) return false;
        uint64_t low = coder_.template plain<kPosition>(
            2 * width.low, width.low_of(known_x) | width.low_of(known_y) << width.low);
        if (HWY_UNLIKELY(are_many) && !coder_.begin()) return false;
        low |= coder_.template plain<kPosition>(width.low, width.low_of(known_z)) << 2 * width.low;
        row_.put(size_class | width.joined(x, low) << kClassBits |
                     width.joined(y, low >> width.low) << (kClassBits + width.all),
                 kClassBits + 2 * width.all);
        row_.put(width.joined(z, low >> 2 * width.low), width.all);
        return true;
    }

    // Those of class 0 have a context of their own, with nothing to be told: no branch.
    HWY_INLINE bool take_normal(RunPlace& place) {
        const uint64_t known = row_.peek();
        const uint32_t size_class =
            coder_.template code<kClassLane, kNormalClass>(last_normal_class_, uint32_t(known) & 3);
        last_normal_class_ = size_class;
        if (HWY_UNLIKELY(size_class == 3)) {
            row_.put(size_class, kClassBits);
            return as_they_are<kCornerNormal>(2 * kAnyNormalWidth);
        }
        const Width width(normal_width(place.normal_width, size_class));
        const uint64_t known_column = known >> kClassBits, known_row = known_column >> width.all;
        const uint32_t column =
            coder_.template code<kFirstLane, kCornerNormal>(size_class, width.high_of(known_column));
        const uint32_t row =
            coder_.template code<kSecondLane, kCornerNormal>(size_class, width.high_of(known_row));
        const uint64_t low = coder_.template plain<kCornerNormal>(
            2 * width.low, width.low_of(known_column) | width.low_of(known_row) << width.low);
        row_.put(size_class | width.joined(column, low) << kClassBits |
                     width.joined(row, low >> width.low) << (kClassBits + width.all),
                 kClassBits + 2 * width.all);
        return true;
    }

    HWY_INLINE bool take_shading(RunPlace&) {
        as_it_is<kNormalClass>(1);
        return true;
    }

    static constexpr uint32_t kWidest = 24;  // what two of have fewer than 57 low bits
    Coder& coder_;
    Row& row_;
    const uint32_t lattice_bits_;
    uint32_t last_is_new_ = 0, last_position_class_ = 0, last_normal_class_ = 0;
};

// All of a block: `total` bits from `place` on, the last `rest` of which are no whole step.  False where
// there is no more input, or it is not of so many bits.
template <class Coder, class Row>
HWY_INLINE bool CodeRuns(Coder& coder, Row& row, RunPlace place, uint32_t rest, uint64_t total,
                         uint32_t lattice_bits) {
    RunSteps steps(coder, row, lattice_bits);
    if (!steps.take_place(place) || !coder.begin()) return false;
    rest = uint32_t(coder.template plain<kGlue>(7, rest));
    return place.cut + rest <= total && row.begin() && steps.template as_they_are<kPosition>(place.cut) &&
           steps.take_steps(place, total - rest) && row.at() == total - rest && coder.begin() &&
           row.begin() && steps.template as_they_are<kPosition>(rest);
}

}  // namespace HWY_NAMESPACE
}  // namespace splat
HWY_AFTER_NAMESPACE();

#endif
