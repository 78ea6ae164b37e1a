// SPDX-License-Identifier: BSD-3-Clause
// What the operations of an instruction set make of seeded inputs. No include guard: each
// .cpp file includes this once, after it has named its set and included that set's header.

#include <superray/core/ray_bundle.h>

#include <array>
#include <cstring>
#include <random>

#include "core/kernels/simd_results.h"
#include "directions/classified_batch.h"
#include "directions/first_unsettled.h"

#include <superray/core/detail/target_begin.h>

namespace superray {
namespace {

using Words = std::array<std::uint64_t, 8>;

/// Runs every operation on random inputs and gathers the results. Lanes leave vectors by
/// memory, in order, so that sets with other registers give the same.
template <typename Simd>
class OperationRun {
 public:
    explicit OperationRun(std::uint64_t seed) : random_(seed) {}

    void all() {
        arithmetic();
        floatingPoint();
        lanes();
        look();
        crossings();
        addresses<0, 1>();
        addresses<0, 2>();
        addresses<1, 2>();
        counts();
        mark();
        runs();
    }
    test::SimdResults results;

 private:
    using Long8 = typename Simd::Long8;

    std::uint64_t word() { return random_(); }
    /// In [0, 2^bits).
    std::int64_t below(int bits) {
        return static_cast<std::int64_t>(word() & ((std::uint64_t{1} << bits) - 1));
    }
    Ints ints(int bits) {
        Ints v;
        for (int i = 0; i < 8; ++i) v[i] = static_cast<std::int32_t>(below(bits));
        return v;
    }
    static Ints loadInts(const std::int32_t* from) {
        Ints v;
        std::memcpy(&v, from, sizeof v);
        return v;
    }

    void keep(const char* operation, std::uint64_t value) {
        results.push_back({operation, value});
    }
    void keep(const char* operation, Ints v) {
        for (int i = 0; i < 8; ++i) keep(operation, static_cast<std::uint32_t>(v[i]));
    }
    void keep(const char* operation, Long8 v, std::uint64_t mask = ~std::uint64_t{0}) {
        std::int64_t lanes[8];
        Simd::store(v, lanes);
        for (std::int64_t lane : lanes)
            keep(operation, static_cast<std::uint64_t>(lane) & mask);
    }
    void keepMask(const char* operation, typename Simd::Mask mask) {
        keep(operation, Simd::select(mask, Ints{} - 1, Ints{}));
    }

    void arithmetic() {
        const std::int64_t base = below(46) - (std::int64_t{1} << 45), step = below(32);
        const Long8 ramp = Simd::ramp(base, step), other = Simd::ramp(below(40), below(32));
        keep("ramp", ramp);
        keep("all", Simd::all(base));
        keep("+", ramp + other);
        keep("-", ramp - other);
        keep("cells", Simd::cells(ramp));
        keep("wholeUnits", Simd::wholeUnits(other));
        keep("product", Simd::product(ramp, other));
        // Example of Portable::cells.
        keep("cells", Simd::cells(Simd::all(-1)));
        // The high halves of negative numbers are any.
        const Ints narrow = ints(32);
        keep("wide", Simd::wide(narrow), 0xFFFFFFFF);
        keep("wide", Simd::wide(narrow & 0x7FFFFFFF));
    }

    void floatingPoint() {
        float singles[64];
        double doubles[64];
        std::uint32_t indices[8];
        for (int i = 0; i < 64; ++i) {
            doubles[i] = static_cast<double>(below(40) - (std::int64_t{1} << 39)) * 0x1p-20;
            singles[i] = static_cast<float>(doubles[i]);
        }
        // Whole numbers and their neighbours.
        doubles[0] = -3.0;
        doubles[1] = 0x1.fffffffffffffp1;
        doubles[2] = -0x1p-60;
        for (std::uint32_t& i : indices) i = static_cast<std::uint32_t>(below(6));
        const auto x = Simd::gatherDoubles(doubles, indices);
        const auto y = Simd::gatherDoubles(singles, indices);
        keep("floorOf", Simd::floorOf(x));
        keep("gatherDoubles", Simd::floorOf(Simd::times(y, 0x1p16)));
        keep("times", Simd::floorOf(Simd::times(x, 1.0 / 3.0)));
        const auto whole = Simd::toDouble(Simd::ramp(below(51) + 1, 0));
        keep("toDouble", Simd::floorOf(whole));
        keep("over", Simd::floorOf(Simd::times(Simd::over(x, whole), 0x1p50)));
    }

    void lanes() {
        const int bits = static_cast<int>(below(8));
        const Ints a = ints(32), b = ints(32), few = ints(1), others = ints(1);
        keepMask("maskOf", Simd::maskOf(bits));
        keep("bitsOf", static_cast<std::uint64_t>(Simd::bitsOf(a)));
        keep("differing", static_cast<std::uint64_t>(Simd::differing(few, others)));
        keep("select", Simd::select(Simd::maskOf(bits), a, b));
        keep("following", Simd::following(a, b));
        std::uint32_t out[16] = {};
        const auto end = Simd::compress(out, (UInts)a, bits);
        keep("compress", static_cast<std::uint64_t>(end - out));
        for (const std::uint32_t* at = out; at != end; ++at) keep("compress", *at);
    }

    void look() {
        std::int32_t table[32];
        for (std::int32_t& entry : table) entry = static_cast<std::int32_t>(below(32));
        keep("gatherInts", Simd::gatherInts(table, ints(5)));
        const UInts four = Simd::twice(1u << 31, 2, 3, 4);
        keep("twice", (Ints)four);
        keep("pickOf4", (Ints)Simd::pickOf4(four, (UInts)ints(32)));
    }

    void crossings() {
        // On borders, and one unit beside them, too: products that are equal.
        const auto position = [&] {
            return below(2) == 0 ? below(40) & ~std::int64_t{kUnitsPerCell - 1}
                                 : below(40) | std::int64_t{kUnitsPerCell - 1};
        };
        const std::int64_t slope = below(31);
        const Long8 a = Simd::ramp(position(), below(31)), b = Simd::ramp(position(), slope);
        keepMask("firstCrosses",
                 Simd::firstCrosses(a, Simd::all(below(31)), b, Simd::all(slope)));
        keepMask("firstCrosses", Simd::firstCrosses(a, Simd::all(slope), a, Simd::all(slope)));
    }

    template <int minor, int axis>
    void addresses() {
        for (std::int32_t flip : {0, -1}) {
            const typename Simd::template Parts<minor, axis> parts(flip);
            keep("Parts", parts.of(ints(20)));
        }
    }

    void counts() {
        std::uint8_t values[64];
        for (std::uint8_t& value : values) value = static_cast<std::uint8_t>(below(8));
        for (std::uint32_t least :
             {1u, 2u, 128u, 255u, static_cast<std::uint32_t>(values[9]) | 1})
            keep("atLeast64", Simd::atLeast64(values, least));
    }

    void mark() {
        FirstUnsettled unsettled[8];
        CellOffset farthest[8];
        for (int i = 0; i < 8; ++i) {
            unsettled[i] = {static_cast<std::uint32_t>(below(32))};
            if (below(2) == 0) unsettled[i] = FirstUnsettled::never();
            farthest[i] = CellOffset{};
            for (int a = 0; a < 3; ++a)
                farthest[i].set(a, static_cast<std::int32_t>(below(2) * 1000 + below(1)));
        }
        CellOffset offset{};
        for (int a = 0; a < 3; ++a) offset.set(a, static_cast<std::int32_t>(below(2) * 1000));
        const auto slice = static_cast<std::int32_t>(below(15));
        const auto columns = static_cast<std::uint32_t>(below(32));
        const auto rows = static_cast<std::uint32_t>(below(16)) & 0x1111u;
        keep("markRow", Simd::markRow(unsettled, farthest, offset, slice, columns, rows));
        for (const FirstUnsettled& bin : unsettled) keep("markRow", bin.word);
    }

    /// Questions about 16 rays in a row; Portable asks them one by one.
    void runs() {
        constexpr int kSubBinBits = 4;
        std::uint32_t subBin[17];
        CellOffset offset[17];
        RayEnd end[17];
        std::uint16_t lastSlice[16];
        FirstUnsettled unsettled[4];
        constexpr std::uint32_t kNone = 3;
        for (int i = 0; i < 17; ++i) {
            subBin[i] = static_cast<std::uint32_t>(below(6));
            offset[i] = CellOffset{};
            offset[i].set(static_cast<int>(below(1)), static_cast<std::int32_t>(below(1)));
            end[i] = below(1) == 0 ? RayEnd::hit : RayEnd::noReturn;
        }
        for (std::uint16_t& slice : lastSlice) slice = static_cast<std::uint16_t>(below(16));
        for (FirstUnsettled& bin : unsettled) bin = {static_cast<std::uint32_t>(below(32))};
        // Compilers may read all 16 of them: the count is for the rest to be left alone.
        const auto count = static_cast<std::size_t>(1 + below(4));
        std::uint64_t bins = 0, offsets = 0, ends = 0, choosable = 0;
        if constexpr (Simd::kRunLanes > 1) {
            for (int i = 0; i < 16; i += Simd::kRunLanes) {
                bins |=
                    std::uint64_t{Simd::template sameBins<kSubBinBits>(subBin + 1 + i, kNone)}
                    << i;
                offsets |= std::uint64_t{Simd::sameOffsets(offset + 1 + i)} << i;
                const unsigned lanes = (1u << Simd::kRunLanes) - 1;  // the others are any
                ends |= std::uint64_t{Simd::sameEnds(end + 1 + i, Simd::kRunLanes) & lanes}
                        << i;
            }
            keep("raysFrom", std::uint64_t{Simd::raysFrom(5)[7]});
        } else {
            for (int i = 0; i < 16; ++i) {
                const std::uint32_t bin = subBin[i + 1] >> kSubBinBits;
                bins |= std::uint64_t{bin == subBin[i] >> kSubBinBits && bin != kNone} << i;
                offsets |= std::uint64_t{offset[i + 1] == offset[i]} << i;
                ends |= std::uint64_t{end[i + 1] == end[i]} << i;
            }
            keep("raysFrom", std::uint64_t{12});
        }
        if constexpr (Simd::kChoiceLanes > 1) {
            choosable =
                Simd::template choosable<kSubBinBits>(subBin, lastSlice, count, unsettled);
        } else {
            for (std::size_t i = 0; i < std::min<std::size_t>(count, 16); ++i) {
                const FirstUnsettled first = unsettled[subBin[i] >> kSubBinBits];
                choosable |=
                    std::uint64_t{first.contains(subBin[i]) && first.slice() <= lastSlice[i]}
                    << i;
            }
        }
        keep("sameBins", bins);
        keep("sameOffsets", offsets);
        keep("sameEnds", ends);
        keep("choosable", choosable);
    }

    std::mt19937_64 random_;
};

}  // namespace
}  // namespace superray

#include <superray/core/detail/target_end.h>
