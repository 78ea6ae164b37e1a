// SPDX-License-Identifier: BSD-3-Clause
// LAS of the ASPRS, versions 1.0 to 1.4, little endian: a header, records of any kind, points
// of equal length that begin with three integers, and from 1.3 on records and waveforms.

#include <superray/eval/input_error.h>

#include <array>
#include <cmath>
#include <cstring>
#include <sstream>
#include <utility>

#include "sources/clouds/cloud_files.h"
#include "sources/clouds/sensor_points.h"
#include "sources/file_bytes.h"

namespace superray {
namespace {

/// Bytes that a point of each format has at least.
constexpr std::array<std::size_t, 11> kPointBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
/// Of a header, by minor version [bytes].
constexpr std::array<std::size_t, 5> kHeaderBytes{227, 227, 227, 235, 375};

/// Where things are in the header [bytes].
enum HeaderOffset : std::size_t {
    kVersion = 24,
    kHeaderSize = 94,
    kPointsStart = 96,
    kFormat = 104,
    kPointSize = 105,
    kCount32 = 107,
    kScales = 131,
    kOffsets = 155,
    kBox = 179,  // largest and smallest x, y, z
    kWaveforms = 227,
    kExtendedRecords = 235,
    kCount64 = 247
};

class LasReader {
 public:
    explicit LasReader(const std::string& path) : path_(path), bytes_(readFileBytes(path)) {
        readHeader();
    }

    mrpt::maps::CSimplePointsMap::Ptr points() const {
        auto points = mrpt::maps::CSimplePointsMap::Create();
        points->reserve(count_);
        for (std::uint64_t i = 0; i < count_; ++i) {
            const std::size_t at = start_ + i * size_;
            std::array<double, 3> p{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                p[axis] = coordinate(axis, read<std::int32_t>(at + 4 * axis), i);
            if (!isWithheld(at)) addSensorPoint(*points, p[0], p[1], p[2]);
        }
        points->mark_as_modified();
        return points;
    }

 private:
    [[noreturn]] void fail(const std::string& why) const {
        throw InputError(path_ + ": is not a whole LAS file: " + why);
    }

    template <class T>
    T read(std::size_t at) const {
        T value;
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }

    void readHeader() {
        if (bytes_.compare(0, 4, "LASF") != 0) fail("it does not begin with LASF");
        if (bytes_.size() < kHeaderBytes[0]) fail("it ends early");
        const int major = read<std::uint8_t>(kVersion),
                  minor = read<std::uint8_t>(kVersion + 1);
        if (major != 1 || minor > 4)
            fail("version " + std::to_string(major) + "." + std::to_string(minor) +
                 "; must be 1.0 to 1.4");
        const auto version = static_cast<std::size_t>(minor);
        const std::size_t header = read<std::uint16_t>(kHeaderSize);
        start_ = read<std::uint32_t>(kPointsStart);
        if (header < kHeaderBytes[version] || start_ < header || start_ > bytes_.size())
            fail("a header of " + std::to_string(header) + " bytes and points from byte " +
                 std::to_string(start_) + " on do not fit its size, or its version 1." +
                 std::to_string(minor));
        readFormat();
        readCount(version);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            scales_[axis] = read<double>(kScales + 8 * axis);
            offsets_[axis] = read<double>(kOffsets + 8 * axis);
            largest_[axis] = read<double>(kBox + 16 * axis);
            smallest_[axis] = read<double>(kBox + 16 * axis + 8);
            if (!(scales_[axis] > 0) || !std::isfinite(scales_[axis] + offsets_[axis]))
                fail("a scale must be > 0, an offset finite");
        }
    }

    void readFormat() {
        constexpr int kCompressedBits = 0xC0;
        const int format = read<std::uint8_t>(kFormat);
        if ((format & kCompressedBits) != 0) throwIsLaz(path_);
        if (static_cast<std::size_t>(format) >= kPointBytes.size())
            fail("point format " + std::to_string(format) + "; must be 0 to 10");
        format_ = format;
        size_ = read<std::uint16_t>(kPointSize);
        const std::size_t least = kPointBytes[static_cast<std::size_t>(format)];
        if (size_ < least)
            fail("points of " + std::to_string(size_) + " bytes; those of format " +
                 std::to_string(format) + " have " + std::to_string(least) + " at least");
    }

    void readCount(std::size_t minor) {
        count_ = read<std::uint32_t>(kCount32);
        std::uint64_t after = bytes_.size();  // where what follows the points begins
        const auto follows = [&](std::uint64_t at) {
            if (at > 0) after = std::min(after, at);
        };
        if (minor >= 3) follows(read<std::uint64_t>(kWaveforms));
        if (minor == 4) {
            follows(read<std::uint64_t>(kExtendedRecords));
            const auto count = read<std::uint64_t>(kCount64);
            if (count_ != 0 && count_ != count)
                fail("its two counts of points differ: " + std::to_string(count_) + " and " +
                     std::to_string(count));
            count_ = count;
        }
        if (after < start_ || count_ > (after - start_) / size_)
            fail("it ends early: " + std::to_string(count_) + " points of " +
                 std::to_string(size_) + " bytes do not fit its size");
        if (!isPadding(bytes_, start_ + count_ * size_, after))
            fail("other data follow its points");
    }

    /// Deleted, as a flag of the point says.
    bool isWithheld(std::size_t at) const {
        constexpr std::size_t kFlags = 15;
        const int bit = format_ < 6 ? 0x80 : 0x04;
        return (read<std::uint8_t>(at + kFlags) & bit) != 0;
    }

    /// \throws InputError if the header says that none is there
    double coordinate(std::size_t axis, std::int32_t number, std::uint64_t point) const {
        const double value = number * scales_[axis] + offsets_[axis];
        const double tolerance = scales_[axis] + 1e-9 * std::abs(value);
        const std::string name(1, static_cast<char>('x' + axis));
        if (!(value >= smallest_[axis] - tolerance && value <= largest_[axis] + tolerance))
            fail("point " + std::to_string(point + 1) + " has " + name + " " + text(value) +
                 ", but its header says " + text(smallest_[axis]) + " to " +
                 text(largest_[axis]) + " ('pdal translate' writes a new header)");
        return value;
    }

    static std::string text(double value) {
        std::ostringstream out;
        out.precision(12);
        out << value;
        return out.str();
    }

    std::string path_, bytes_;
    std::size_t start_ = 0, size_ = 0;  ///< of the points [bytes]
    std::uint64_t count_ = 0;
    int format_ = 0;
    std::array<double, 3> scales_{}, offsets_{}, largest_{}, smallest_{};
};

}  // namespace

mrpt::maps::CSimplePointsMap::Ptr readLas(const std::string& path) {
    return LasReader(path).points();
}

void throwIsLaz(const std::string& path) {
    throw InputError(path +
                     ": is compressed (LAZ); unpack it with 'las2las -i x.laz -o x.las' or "
                     "'pdal translate x.laz x.las'");
}

}  // namespace superray
