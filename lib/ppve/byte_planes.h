// Numbers apart into their bytes, a plane each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ppve {

// The bits that any of the numbers has.
uint32_t bits_of_any(std::span<const uint32_t> numbers);

// Byte `byte` (0 is the lowest, to 3) of each number; `plane` has their count.  By the processor's widest
// registers: it is a seventh of the time of coding an image otherwise.
void take_byte(std::span<const uint32_t> numbers, int byte, uint8_t* plane);

}  // namespace ppve
