// SPDX-License-Identifier: BSD-3-Clause
#include <mrpt/math/CQuaternion.h>
#include <superray/eval/input_error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "sources/clouds/cloud_files.h"
#include "sources/clouds/scalar_field.h"
#include "sources/clouds/sensor_points.h"
#include "sources/file_bytes.h"
#include "sources/text_numbers.h"

namespace superray {
namespace {

struct Field {
    std::string name;
    ScalarField scalar;
    std::size_t count = 1;
};

struct Header {
    std::vector<Field> fields;
    std::size_t pointBytes = 0, columns = 0;
    std::uint64_t points = 0;
    std::string data;
    std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};  // x y z, quaternion w x y z
};

constexpr double kMostPoints = 1e9;
/// A header of 1000 fields with long names is far below.
constexpr std::uint64_t kMostHeaderBytes = 1 << 20;

class PcdReader {
 public:
    PcdReader(const std::string& path, std::string bytes)
        : path_(path), bytes_(std::move(bytes)) {
        readHeader();
    }

    mrpt::maps::CSimplePointsMap::Ptr points() {
        auto points = mrpt::maps::CSimplePointsMap::Create();
        if (header_.data == "ascii") {
            readAscii(*points);
        } else if (header_.data == "binary") {
            const std::uint64_t expected = header_.points * header_.pointBytes;
            if (bytes_.size() - at_ < expected)
                fail("it ends early: " + std::to_string(header_.points) + " points of " +
                     std::to_string(header_.pointBytes) + " bytes do not fit its size");
            readRecords(bytes_.data() + at_, *points);
            at_ += expected;
        } else if (header_.data == "binary_compressed") {
            readCompressed(*points);
        } else {
            fail("DATA '" + header_.data + "': must be ascii, binary or binary_compressed");
        }
        if (!isPadding(bytes_, at_)) fail("other data follow its points");
        viewpoint();  // must be one
        points->mark_as_modified();
        return points;
    }

    std::optional<mrpt::poses::CPose3D> viewpoint() const {
        const auto& v = header_.viewpoint;
        if (v == std::array<double, 7>{0, 0, 0, 1, 0, 0, 0}) return std::nullopt;
        const double norm = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
        if (!(std::abs(norm - 1) < 0.01)) fail("VIEWPOINT has no unit quaternion");
        const mrpt::math::CQuaternionDouble q(v[3] / norm, v[4] / norm, v[5] / norm,
                                              v[6] / norm);
        return mrpt::poses::CPose3D(q, v[0], v[1], v[2]);
    }

 private:
    [[noreturn]] void fail(const std::string& why) const {
        throw InputError(path_ + ": is not a whole PCD file: " + why);
    }

    std::string nextLine() {
        const auto end = bytes_.find('\n', at_);
        if (end == std::string::npos) fail("its header ends early");
        std::string line = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        if (!line.empty() && line.back() == '\r') line.pop_back();
        return line;
    }

    std::uint64_t wholeNumber(const std::string& word, const std::string& what) const {
        const auto number = parseNumber(word);
        if (!number || *number < 0 || *number > kMostPoints || std::floor(*number) != *number)
            fail(what + " '" + word + "' must be a whole number of at most 1e9");
        return static_cast<std::uint64_t>(*number);
    }

    void readHeader() {
        std::vector<std::string> names, sizes, types, counts;
        std::set<std::string> keys;
        std::uint64_t width = 0, height = 1;
        bool hasPoints = false;
        while (header_.data.empty()) {
            const auto words = wordsOf(nextLine());
            if (words.empty() || words[0][0] == '#') continue;
            const std::vector<std::string> rest(words.begin() + 1, words.end());
            const std::string& key = words[0];
            if (rest.empty()) fail(key + " has no value");
            if (!keys.insert(key).second) fail("its header has a second line " + key);
            if (key == "FIELDS") names = rest;
            if (key == "SIZE") sizes = rest;
            if (key == "TYPE") types = rest;
            if (key == "COUNT") counts = rest;
            if (key == "WIDTH") width = wholeNumber(rest[0], key);
            if (key == "HEIGHT") height = wholeNumber(rest[0], key);
            if (key == "POINTS") {
                header_.points = wholeNumber(rest[0], key);
                hasPoints = true;
            }
            if (key == "VIEWPOINT") readViewpoint(rest);
            if (key == "DATA") header_.data = rest[0];
        }
        if (!hasPoints) header_.points = width * height;
        if (header_.points != width * height)
            fail("POINTS " + std::to_string(header_.points) + " is not WIDTH x HEIGHT, " +
                 std::to_string(width) + " x " + std::to_string(height));
        if (counts.empty()) counts.assign(names.size(), "1");
        if (sizes.size() != names.size() || types.size() != names.size() ||
            counts.size() != names.size())
            fail("FIELDS, SIZE, TYPE and COUNT must have as many entries");
        for (std::size_t i = 0; i < names.size(); ++i)
            addField(names[i], sizes[i], types[i], counts[i]);
        for (const char* axis : {"x", "y", "z"}) {
            if (std::count(names.begin(), names.end(), axis) > 1)
                fail(std::string("it has a second field '") + axis + "'");
            fieldOf(axis);
        }
    }

    void readViewpoint(const std::vector<std::string>& words) {
        std::string line;
        for (const auto& w : words) line += w + " ";
        const auto numbers = parseNumbers(line);
        if (!numbers || numbers->size() != 7) fail("VIEWPOINT must be seven numbers");
        std::copy(numbers->begin(), numbers->end(), header_.viewpoint.begin());
    }

    void addField(const std::string& name, const std::string& size, const std::string& type,
                  const std::string& count) {
        Field field;
        field.name = name;
        field.count = wholeNumber(count, "COUNT");
        field.scalar.bytes = wholeNumber(size, "SIZE");
        field.scalar.offset = header_.pointBytes;
        if (type == "I") field.scalar.kind = ScalarKind::signedInt;
        if (type == "U") field.scalar.kind = ScalarKind::unsignedInt;
        if ((type != "I" && type != "U" && type != "F") || !field.scalar.isValid())
            fail("field '" + name + "' of TYPE " + type + " and SIZE " + size +
                 ": unknown kind of number");
        if (field.count > 1u << 20 || header_.fields.size() > 1000)
            fail("it has more than 1000 fields, or COUNT " + count + " of more than 1048576");
        header_.pointBytes += field.scalar.bytes * field.count;
        header_.columns += field.count;
        header_.fields.push_back(field);
    }

    const Field& fieldOf(const std::string& name) const {
        for (const Field& f : header_.fields)
            if (f.name == name && f.count == 1) return f;
        fail("it has no field '" + name + "'");
    }

    /// Number of the value of a field in a row of text.
    std::size_t columnOf(const std::string& name) const {
        std::size_t column = 0;
        const Field& wanted = fieldOf(name);
        for (const Field& f : header_.fields) {
            if (&f == &wanted) return column;
            column += f.count;
        }
        return column;
    }

    void readAscii(mrpt::maps::CSimplePointsMap& points) {
        const std::size_t x = columnOf("x"), y = columnOf("y"), z = columnOf("z");
        std::uint64_t rows = 0;
        while (at_ < bytes_.size()) {
            const auto end = std::min(bytes_.find('\n', at_), bytes_.size());
            const auto words = wordsOf(bytes_.substr(at_, end - at_));
            if (!words.empty()) {
                if (end == bytes_.size()) fail("its last line is not ended");
                if (words.size() != header_.columns)
                    fail("point " + std::to_string(rows + 1) + " has " +
                         std::to_string(words.size()) + " values, must have " +
                         std::to_string(header_.columns));
                addSensorPoint(points, value(words[x]), value(words[y]), value(words[z]));
                ++rows;
            }
            at_ = std::min(end + 1, bytes_.size());
        }
        if (rows != header_.points)
            fail("it has " + std::to_string(rows) + " of " + std::to_string(header_.points) +
                 " points");
    }

    double value(const std::string& word) const {
        const auto number = parseCoordinate(word);
        if (!number) fail("'" + word + "' is not a number");
        return *number;
    }

    void readRecords(const char* records, mrpt::maps::CSimplePointsMap& points) const {
        const ScalarField x = fieldOf("x").scalar, y = fieldOf("y").scalar,
                          z = fieldOf("z").scalar;
        points.reserve(header_.points);
        for (std::uint64_t i = 0; i < header_.points; ++i, records += header_.pointBytes)
            addSensorPoint(points, x.read(records), y.read(records), z.read(records));
    }

    /// Two sizes, then LZF data: field by field, where a record is point by point.
    void readCompressed(mrpt::maps::CSimplePointsMap& points) {
        std::array<std::uint32_t, 2> sizes{};
        if (bytes_.size() - at_ < sizeof sizes) fail("it ends early");
        std::memcpy(sizes.data(), bytes_.data() + at_, sizeof sizes);
        at_ += sizeof sizes;
        if (sizes[0] > bytes_.size() - at_) fail("it ends early");
        const std::uint64_t expected = header_.points * header_.pointBytes;
        if (sizes[1] != expected)
            fail("its data have " + std::to_string(sizes[1]) + " bytes, " +
                 std::to_string(header_.points) + " points of " +
                 std::to_string(header_.pointBytes) + " bytes have " +
                 std::to_string(expected));
        const std::string data = decompress(bytes_.data() + at_, sizes[0], sizes[1]);
        at_ += sizes[0];
        const auto plane = [&](const Field& f) {
            return data.data() + f.scalar.offset * header_.points;
        };
        const Field &x = fieldOf("x"), &y = fieldOf("y"), &z = fieldOf("z");
        const auto at = [&](const Field& f, std::uint64_t i) {
            ScalarField scalar = f.scalar;
            scalar.offset = i * f.scalar.bytes;
            return scalar.read(plane(f));
        };
        points.reserve(header_.points);
        for (std::uint64_t i = 0; i < header_.points; ++i)
            addSensorPoint(points, at(x, i), at(y, i), at(z, i));
    }

    /// LZF: runs of up to 32 bytes as they are, and copies of up to 264 bytes from up to
    /// 8 kB before.
    std::string decompress(const char* in, std::size_t size, std::size_t expected) const {
        if (expected > 90 * size + 64) fail("its compressed data claim an impossible size");
        std::string out;
        out.reserve(expected);
        std::size_t i = 0;
        const auto next = [&]() -> unsigned {
            if (i >= size) fail("its compressed data end early");
            return static_cast<unsigned char>(in[i++]);
        };
        while (i < size && out.size() < expected) {
            const unsigned control = next();
            if (control < 32) {
                if (control + 1 > size - i) fail("its compressed data end early");
                out.append(in + i, control + 1);
                i += control + 1;
                continue;
            }
            std::size_t length = control >> 5;
            if (length == 7) length += next();
            length += 2;
            const std::size_t back = ((control & 31u) << 8 | next()) + 1;
            if (back > out.size()) fail("its compressed data are damaged");
            for (std::size_t k = 0; k < length; ++k) out.push_back(out[out.size() - back]);
        }
        if (out.size() != expected || i != size) fail("its compressed data are damaged");
        return out;
    }

    std::string path_, bytes_;
    std::size_t at_ = 0;
    Header header_;
};

}  // namespace

mrpt::maps::CSimplePointsMap::Ptr readPcd(const std::string& path) {
    return PcdReader(path, readFileBytes(path)).points();
}

std::optional<mrpt::poses::CPose3D> readPcdViewpoint(const std::string& path) {
    return PcdReader(path, readFileBytes(path, kMostHeaderBytes)).viewpoint();
}

}  // namespace superray
