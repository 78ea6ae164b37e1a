// SPDX-License-Identifier: BSD-3-Clause
// Small sets of rays on and beside borders of cells: every method, policy and instruction
// set of the process against the oracle. A difference is thrown, and so a finding.

#include <cmath>
#include <stdexcept>

#include "core/lattice_map.h"
#include "fuzz/target.h"

namespace superray::fuzz {
namespace {

/// Bytes of an input, in order; 0 past its end.
class Bytes {
 public:
    explicit Bytes(const std::string& input) : input_(input) {}
    bool left() const { return at_ < input_.size(); }
    int next() { return left() ? static_cast<unsigned char>(input_[at_++]) : 0; }
    int nextSigned() { return static_cast<signed char>(next()); }

 private:
    const std::string& input_;
    std::size_t at_ = 0;
};

/// A coordinate [cells] of three bytes: a border, and how far beside it.
double coordinate(Bytes& bytes) {
    const int kind = bytes.next();
    const double border = bytes.nextSigned(), beside = bytes.nextSigned();
    switch (kind % 6) {
        case 0:
            return border;
        case 1:  // units of the digital line
            return border + beside * 0x1p-31;
        case 2:
            return border + beside * 1e-15;
        case 3:
            return std::nextafter(border, beside);
        case 4:
            return border + std::ldexp(beside, -kind / 6);
        default:
            return border + beside / 256;
    }
}

/// One set of rays: a head of 4 bytes, the origin, and up to 8 end points.
template <int Dim>
void tryOneSet(Bytes& bytes, int head) {
    constexpr double kResolutions[] = {1.0, 0.1, 0.3, 0.05};
    const double resolution = kResolutions[head >> 1 & 3];
    const test::HoledMap<Dim> map(static_cast<std::uint64_t>(bytes.next()),
                                  1 + static_cast<std::uint64_t>(bytes.next() % 64));
    const int ends = bytes.next();
    const auto point = [&] {
        Point<Dim> p;
        for (int a = 0; a < Dim; ++a) p[a] = coordinate(bytes) * resolution;
        return p;
    };
    RayBundle<Dim> exact(CellGeometry<Dim>(resolution), point());
    for (int i = 0; i <= (head >> 3 & 7); ++i)
        exact.add(point(), (ends >> i & 1) != 0 ? RayEnd::noReturn : RayEnd::hit);
    const auto expected = countCells(exact);
    static ScanIntegrator<Dim> integrator;
    const std::string different =
        test::firstDifferentRun<Dim>(exact, expected, map, 1, integrator, [](auto&&...) {});
    if (!different.empty()) throw std::logic_error(different + ": not as the oracle says");
}

std::string seed(int head, std::uint64_t pattern) {
    std::string bytes{static_cast<char>(head)};
    for (int i = 0; i < 48; ++i) {
        pattern = pattern * 6364136223846793005u + 1442695040888963407u;
        // Small borders, so that rays meet.
        bytes += static_cast<char>(i % 3 == 1 ? static_cast<int>(pattern >> 60) - 8
                                              : static_cast<int>(pattern >> 56));
    }
    return bytes;
}

}  // namespace

std::vector<std::string> seeds() {
    std::vector<std::string> all;
    for (int head = 0; head < 64; ++head)
        all.push_back(seed(head, static_cast<std::uint64_t>(head)));
    // An origin on a border, and two ends on its two sides, nearly parallel to an axis.
    all.push_back(
        std::string({8, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5, 0, 2, 0, 1, 0, 5, 0, 2, 0, -1}));
    return all;
}

void run(const std::string& input) {
    Bytes bytes(input);
    for (int sets = 0; bytes.left() && sets < 16; ++sets) {
        const int head = bytes.next();
        (head & 1) != 0 ? tryOneSet<3>(bytes, head) : tryOneSet<2>(bytes, head);
    }
}

}  // namespace superray::fuzz
