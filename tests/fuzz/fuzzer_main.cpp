// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry.

#include <cstddef>
#include <cstdint>

#include "fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    superray::fuzz::run({reinterpret_cast<const char*>(data), size});
    return 0;
}
